//! The rule that turns a machine into gains for actuators as built: soft, sampled, late.
//!
//! Each gain stands in a fixed ratio to what bounds it. The ratios are those of the gains that keep
//! the reference machine in every plant of the tests; the reasoning is in `docs/machines.md`.

use crate::Machine;

/// Feedback on the tip, as a part of the lowest mode's frequency; its integral, as a part of it.
const LAMBDA: f64 = 0.42;
const INTEGRAL: f64 = 0.5;
/// Frequency of the adaptation that acts as a spring, as a part of the lowest mode's.
const ADAPTATION: f64 = 0.3;
/// Bandwidth of a motor's velocity, and of the disturbance observer beside it, 1/s: with readings of
/// one step of 1 ms, a network and a current loop three steps more leave half a radian of phase.
const MOTOR: f64 = 65.0;
const OBSERVER: f64 = 60.0;
/// Damping of the wrist over its inertia, and feedback on the orientation, 1/s: a drive that lags
/// by 5 ms and sticks leaves no more. As a rate it is the same for every machine, because
/// `K_A` = `kappa_KA` × inertia.
const WRIST: f64 = 20.0;
const TURN: f64 = 5.0;

/// What bounds the gains of a machine, at its start pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest mode of the booms on actuators as built whose motors stand, rad/s.
    pub mode: f64,
    /// Root of the sum of the bodies' squared moments of gravity about the lift joint, N·m.
    pub moment: f64,
    /// Inertia about the lift joint, kg·m².
    pub inertia: f64,
    /// Bandwidth of the fastest motor's velocity for a `K_v` of 1 V·s/m, 1/s.
    pub motor: f64,
}

/// A gain of the controller by the rule.
#[derive(Clone, Debug, PartialEq)]
pub struct RuledGain {
    /// Variable of the controller.
    pub name: &'static str,
    /// Value, of two digits.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
    /// What it is made of.
    pub why: String,
}

/// The gains of a machine with these bounds. The adaptation's gain is
/// ```text
/// γ = Σ_k (m_k g x_k)² / (M ω_a²)
/// ```
/// because the law `L̂' = L̂ S L̂/γ` gives each body's moment of gravity the rate `(m g x)²/γ` per
/// velocity error: a spring of that stiffness on the inertia M.
pub fn gains(machine: &Machine, bounds: &Bounds) -> Vec<RuledGain> {
    let gain = |name, value, unit, why| RuledGain {
        name,
        value: two_digits(value),
        unit,
        why,
    };
    let Bounds {
        mode,
        moment,
        inertia,
        motor,
    } = *bounds;
    let lambda = two_digits(LAMBDA * mode);
    let adapted = ADAPTATION * mode;
    let hertz = mode / std::f64::consts::TAU;
    vec![
        gain(
            "Lambda_position",
            lambda,
            "1/s",
            format!("{LAMBDA} of the lowest mode, {hertz:.1} Hz"),
        ),
        gain(
            "omega_tip",
            INTEGRAL * lambda,
            "1/s",
            format!("{INTEGRAL} of Lambda_position"),
        ),
        gain(
            "gamma",
            moment * moment / (inertia * adapted * adapted),
            "J",
            format!(
                "moments of {moment:.0} N.m on {inertia:.0} kg.m2, adapted at {ADAPTATION} of the mode"
            ),
        ),
        gain(
            "K_v",
            MOTOR / motor,
            "V.s/m",
            format!(
                "a motor loop of {MOTOR} 1/s with K_i = {}",
                machine.controller.K_i
            ),
        ),
        gain("omega_d", OBSERVER, "1/s", "sampling and delay".into()),
        gain("kappa_KA", WRIST, "1/s", "lag of the wrist's drives".into()),
        gain(
            "Lambda_orientation",
            TURN,
            "1/s",
            format!("{} of kappa_KA", TURN / WRIST),
        ),
    ]
}

/// Rounded to two digits.
fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().expect("a number")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(gains: &[RuledGain], name: &str) -> f64 {
        let found = gains.iter().find(|gain| gain.name == name);
        found.expect("a gain").value
    }

    /// By hand: 0.42·30 = 12.6, rounded 13, half of it 6.5; (2e4)²/(4000·(0.3·30)²) = 1235; 65/0.16 = 406.
    #[test]
    fn gains_are_in_proportion_to_what_bounds_them() {
        let bounds = Bounds {
            mode: 30.0,
            moment: 2e4,
            inertia: 4e3,
            motor: 0.16,
        };
        let gains = gains(&Machine::reference(), &bounds);
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

    #[test]
    fn numbers_have_two_digits() {
        for (value, rounded) in [
            (0.01234, 0.012),
            (12.49, 12.0),
            (987.0, 990.0),
            (999.0, 1000.0),
        ] {
            assert!((two_digits(value) / rounded - 1.0).abs() < 1e-12, "{value}");
        }
    }
}
