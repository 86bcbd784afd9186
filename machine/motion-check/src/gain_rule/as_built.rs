//! The gains for actuators as built, of [`super`].

use super::bounds::{Bounds, bounds};
use super::error::GainError;
use super::ideal::ideal_gains;
use super::ruled_gain::{RuledGain, give, two_digits};
use hdrm::HdrmError;
use machine_file::Machine;

/// Feedback on the tip over the lowest mode's frequency; rate of its integral over that feedback.
const LAMBDA: f64 = 0.42;
const INTEGRAL: f64 = 0.5;
/// Frequency at which the adaptation acts as a spring, over the lowest mode's.
const ADAPTATION: f64 = 0.3;
/// Bandwidth of a motor's velocity loop, and of the disturbance observer in parallel, 1/s: with
/// readings one step of 1 ms old, and three more for network and current loop, half a radian of
/// phase remains.
const MOTOR: f64 = 65.0;
const OBSERVER: f64 = 60.0;
/// Damping of the wrist over its inertia, and feedback on the orientation, 1/s: the most that a
/// drive with 5 ms of lag and stiction allows. As a rate it is the same for every machine, because
/// `K_A` = `kappa_KA` × inertia.
const WRIST: f64 = 20.0;
const TURN: f64 = 5.0;
/// Rate at which the wrist's friction is estimated, over its damping: both loops stay well damped.
const FRICTION: f64 = 0.2;
/// Share of it at the rods: their motors have a feedback of their own, and with both a boom on a soft
/// mounting swings.
const RODS: f64 = 0.3;

/// The gains of a machine with actuators as built.
pub fn gains(machine: &Machine) -> Result<Vec<RuledGain>, GainError> {
    gains_beside(machine, &[])
}

/// The gains of a machine with actuators as built, for a user who gives `own` values to some: they
/// fit those.
///
/// The motors bound `Lambda_position` as in the ideal world. Where the rule has none for that world,
/// the machine file's own counts.
pub fn gains_beside(
    machine: &Machine,
    own: &[(&'static str, f64)],
) -> Result<Vec<RuledGain>, GainError> {
    let known = Machine::reference().controller;
    let mut machine = machine.clone();
    let filed = machine.controller.Lambda_position;
    give(&mut machine.controller, own);
    let bounds = bounds(&machine)?;
    if let Some((_, said)) = own.iter().find(|(name, _)| *name == "Lambda_position") {
        return Ok(within(&machine, &bounds, said / (LAMBDA * bounds.mode)));
    }
    let silent = Machine {
        controller: known,
        ..machine.clone()
    };
    let feedback = match ideal_gains(&silent) {
        Ok(ruled) => ruled
            .iter()
            .find(|gain| gain.name == "Lambda_position")
            .map(|gain| gain.value),
        Err(GainError::Undamped(..)) if filed != known.Lambda_position => {
            Some(filed.min(known.Lambda_position))
        }
        Err(error) => return Err(error),
    };
    let feedback = feedback.expect("a silent machine has every gain by the rule");
    Ok(within(&machine, &bounds, feedback / known.Lambda_position))
}

/// The adaptation gain alone, J.
pub fn gamma(machine: &Machine) -> Result<f64, HdrmError> {
    let gains = within(machine, &bounds(machine)?, 1.0);
    let gamma = gains.iter().find(|gain| gain.name == "gamma");
    Ok(gamma.expect("a gain of the rule").value)
}

/// The gains of a machine with these bounds. The adaptation gain is
/// ```text
/// γ = Σ_k (m_k g x_k)² / (M ω_a²)
/// ```
/// because the law `L̂' = L̂ S L̂/γ` gives each body's moment of gravity the rate `(m g x)²/γ` per
/// velocity error: a spring of that stiffness on the inertia M.
///
/// `heavy` is what heavy motors leave of the feedback on the tip, as in [`ideal_gains`].
fn within(machine: &Machine, bounds: &Bounds, heavy: f64) -> Vec<RuledGain> {
    let Bounds {
        mode,
        moment,
        inertia,
        motor,
    } = *bounds;
    let lambda = two_digits(LAMBDA * heavy * mode);
    let adapted = ADAPTATION * mode;
    let gamma = moment * moment / (inertia * adapted * adapted);
    let hertz = mode / std::f64::consts::TAU;
    let mut of_mode = format!("{LAMBDA} of the lowest mode, {hertz:.1} Hz");
    if heavy < 1.0 {
        of_mode += &format!(", times {heavy:.2} for heavy motors");
    }
    let of_lambda = format!("{INTEGRAL} of Lambda_position");
    let of_moments = format!(
        "moments of {moment:.0} N.m on {inertia:.0} kg.m2, adapted at {ADAPTATION} of the mode"
    );
    let K_i = machine.controller.K_i;
    let of_motor = format!("a motor loop of {MOTOR} 1/s with K_i = {K_i}");
    let of_wrist = format!("{} of kappa_KA", TURN / WRIST);
    let of_friction = format!("{FRICTION} of kappa_KA");
    let rod = |name| (name, RODS, "1", "the motors' feedback K_v".into());
    let gains = [
        ("Lambda_position", lambda, "1/s", of_mode),
        ("omega_tip", INTEGRAL * lambda, "1/s", of_lambda),
        ("gamma", gamma, "J", of_moments),
        ("K_v", MOTOR / motor, "V.s/m", of_motor),
        ("omega_d", OBSERVER, "1/s", "sampling and delay".into()),
        ("kappa_KA", WRIST, "1/s", "lag of the wrist's drives".into()),
        rod("kappa_share[1]"),
        rod("kappa_share[2]"),
        rod("kappa_share[3]"),
        ("Lambda_orientation", TURN, "1/s", of_wrist),
        ("omega_friction", FRICTION * WRIST, "1/s", of_friction),
    ];
    let rounded = gains.map(|(name, value, unit, why)| RuledGain {
        name,
        value: two_digits(value),
        unit,
        why,
    });
    rounded.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gain_rule::tests::value;

    /// By hand: 0.42·30 = 12.6, rounded 13, half of it 6.5; (2e4)²/(4000·(0.3·30)²) = 1235; 65/0.16
    /// = 406.
    #[test]
    fn gains_are_in_proportion_to_what_bounds_them() {
        let bounds = Bounds {
            mode: 30.0,
            moment: 2e4,
            inertia: 4e3,
            motor: 0.16,
        };
        let gains = within(&Machine::reference(), &bounds, 1.0);
        for (name, expected) in [
            ("Lambda_position", 13.0),
            ("omega_tip", 6.5),
            ("gamma", 1200.0),
            ("K_v", 410.0),
        ] {
            let found = value(&gains, name);
            assert_eq!(found, expected, "{name}");
        }
    }
}
