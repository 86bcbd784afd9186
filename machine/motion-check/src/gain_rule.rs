//! Computes controller gains for a machine whose actuators are not ideal: compliant, sampled and
//! delayed. Used by `hdrm-fmu machine gains`, the setup of experiments and the Python package.
//!
//! Each gain is a fixed ratio of the quantity that bounds it. The ratios are those with which the
//! reference machine is stable in every plant of the tests; `docs/machines.md` has the reasoning.

use emla::maps;
use hdrm::{Hdrm, HdrmError, Options, State};
use machine_file::Machine;
use nalgebra::Matrix2;

/// Assumed stiffness of mounting and pins, N/m: that of the actuators as built.
const MOUNTING: f64 = 6e7;
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
/// Share of it at the rods: their motors have a feedback of their own, and with both a boom on a soft
/// mounting swings.
const RODS: f64 = 0.3;

/// The quantities that bound the gains of a machine, at its start pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest mode of the booms on compliant actuators with locked motors, rad/s.
    pub mode: f64,
    /// Root of the sum of the bodies' squared moments of gravity about the lift joint, N·m.
    pub moment: f64,
    /// Inertia about the lift joint, kg·m².
    pub inertia: f64,
    /// Bandwidth of the fastest motor's velocity for a `K_v` of 1 V·s/m, 1/s.
    pub motor: f64,
}

/// A gain of the controller as the rule gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct RuledGain {
    /// Variable of the controller.
    pub name: &'static str,
    /// Value, of two digits.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
    /// How the value comes about, in words.
    pub why: String,
}

/// The gains of a machine.
pub fn gains(machine: &Machine) -> Result<Vec<RuledGain>, HdrmError> {
    Ok(within(machine, &bounds(machine)?))
}

/// The adaptation gain alone, J.
pub fn gamma(machine: &Machine) -> Result<f64, HdrmError> {
    let gains = gains(machine)?;
    let gamma = gains.iter().find(|gain| gain.name == "gamma");
    Ok(gamma.expect("a gain of the rule").value)
}

/// The bounds of a machine's gains.
pub fn bounds(machine: &Machine) -> Result<Bounds, HdrmError> {
    let plant = Hdrm::new(machine, &Options::from_machine(machine))?;
    let zeta = machine.start.zeta;
    let strokes = plant.tree().configuration(&zeta).strokes;
    let rest = State {
        zeta,
        ..State::default()
    };
    let (M, _) = plant.equations_of_motion(&rest);
    let booms: Matrix2<f64> = M.fixed_view::<2, 2>(1, 1).into();
    let springs = [1, 2].map(|k| {
        let inside = 1.0 / maps::stiffness(machine.emla.in_order()[k], strokes[k].x);
        strokes[k].prime.powi(2) / (inside + 1.0 / MOUNTING)
    });
    // ω² of K q = ω² M q are the inverses of the eigenvalues of K^(−1/2) M K^(−1/2).
    let root = Matrix2::from_diagonal(&springs.map(|k| 1.0 / k.sqrt()).into());
    let slowest = (root * booms * root).symmetric_eigenvalues().max();
    let lift = |plant: &Hdrm| plant.holding(&zeta).0[1] * strokes[1].prime;
    let mut square = 0.0;
    for k in 0..machine.bodies.in_order().len() {
        let mut half = machine.clone();
        half.bodies.in_order_mut()[k].mass *= 0.5;
        let without = Hdrm::new(&half, &Options::from_machine(&half))?;
        square += (2.0 * (lift(&plant) - lift(&without))).powi(2);
    }
    let motors = machine.emla.in_order().map(|p| {
        let per_ampere = 1.5 * f64::from(p.p) * p.lambda_m;
        let load = maps::gear_factor(p, 1.0, 0.0);
        per_ampere / machine.controller.K_i * maps::travel_per_radian(p) / maps::inertia(p, load)
    });
    Ok(Bounds {
        mode: slowest.sqrt().recip(),
        moment: square.sqrt(),
        inertia: booms[(0, 0)],
        motor: motors.into_iter().fold(0.0, f64::max),
    })
}

/// The gains of a machine with these bounds. The adaptation gain is
/// ```text
/// γ = Σ_k (m_k g x_k)² / (M ω_a²)
/// ```
/// because the law `L̂' = L̂ S L̂/γ` gives each body's moment of gravity the rate `(m g x)²/γ` per
/// velocity error: a spring of that stiffness on the inertia M.
fn within(machine: &Machine, bounds: &Bounds) -> Vec<RuledGain> {
    let Bounds {
        mode,
        moment,
        inertia,
        motor,
    } = *bounds;
    let lambda = two_digits(LAMBDA * mode);
    let adapted = ADAPTATION * mode;
    let gamma = moment * moment / (inertia * adapted * adapted);
    let hertz = mode / std::f64::consts::TAU;
    let of_mode = format!("{LAMBDA} of the lowest mode, {hertz:.1} Hz");
    let of_lambda = format!("{INTEGRAL} of Lambda_position");
    let of_moments = format!(
        "moments of {moment:.0} N.m on {inertia:.0} kg.m2, adapted at {ADAPTATION} of the mode"
    );
    let K_i = machine.controller.K_i;
    let of_motor = format!("a motor loop of {MOTOR} 1/s with K_i = {K_i}");
    let of_wrist = format!("{} of kappa_KA", TURN / WRIST);
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
    ];
    let rounded = gains.map(|(name, value, unit, why)| RuledGain {
        name,
        value: two_digits(value),
        unit,
        why,
    });
    rounded.into()
}

/// `value` rounded to two digits.
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
        let gains = within(&Machine::reference(), &bounds);
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

    /// A load on one spring has ω² = k/M: with the tilt boom and all that it carries made light,
    /// the lower mode is that of the lift boom on its rod, to the part that the light boom weighs.
    #[test]
    fn the_mode_is_that_of_a_load_on_a_spring() {
        let mut machine = Machine::reference();
        for body in machine.bodies.in_order_mut().into_iter().skip(4) {
            body.mass *= 1e-5;
            let I = &mut body.inertia_com;
            for moment in [
                &mut I.xx, &mut I.yy, &mut I.zz, &mut I.xy, &mut I.xz, &mut I.yz,
            ] {
                *moment *= 1e-5;
            }
        }
        let bounds = bounds(&machine).expect("bounds");
        let plant = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("a plant");
        let stroke = plant.tree().configuration(&machine.start.zeta).strokes[1];
        let screw = maps::stiffness(&machine.emla.lift, stroke.x);
        let spring = stroke.prime.powi(2) / (1.0 / screw + 1.0 / MOUNTING);
        let expected = (spring / bounds.inertia).sqrt();
        let found = bounds.mode / expected;
        assert!((found - 1.0).abs() < 1e-3, "{found}");
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
