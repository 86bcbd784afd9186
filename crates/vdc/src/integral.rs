//! Integral of the tracking error, in the modes that have one.
//!
//! Not in the paper. Without it a controller that compensates no unknown load stands beside its reference by a constant sag, which any
//! integral removes; with it the comparison shows what else adaptation brings. It shifts the reference of the inverse kinematics by z,
//! `z' = ω e`: with the feedback Λ the error follows `s² + Λ s + Λ ω = 0`, whose roots are equal at `ω = Λ/4`.

use crate::evaluation::Evaluation;
use crate::low_level::Command;
use crate::{Controller, Settings};
use nalgebra::Vector6;

/// Errors that the feedback acts on: of the tip, position m and orientation rad; at [`crate::Level::Actuator`] of the rods, m, in the first
/// three places.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Errors {
    /// Desired minus actual, e.
    pub(crate) e: Vector6<f64>,
    /// Integral part z; zero in the modes without.
    pub(crate) z: Vector6<f64>,
    /// `z' = ω e`.
    pub(crate) z_dot: Vector6<f64>,
}

impl Controller {
    /// The error `e` with its integral part.
    pub(crate) fn errors(&self, settings: &Settings, e: Vector6<f64>) -> Errors {
        let [z, z_dot] = match settings.integral {
            true => [self.state.integral, e * settings.gains.omega_tip],
            false => [Vector6::zeros(); 2],
        };
        Errors { e, z, z_dot }
    }

    /// Advances z by `h` s with the error of `now` held. While a drive or a wrist joint is at its limit z rests, or it would wind up.
    pub(crate) fn advance_integral(&mut self, now: &Evaluation, h: f64) {
        if !self.is_at_limit(now) {
            self.state.integral += now.errors.z_dot * h;
        }
    }

    /// Whether a command of `now` is at a limit: voltage or current of a drive, torque of a wrist joint.
    fn is_at_limit(&self, now: &Evaluation) -> bool {
        let drive = |c: &Command| c.voltage() >= c.v_max || c.i_qr.abs() >= c.i_max;
        let mut wrist = now.tau_wrist().into_iter().zip(self.nominal.tau_wrist_max);
        now.commands.iter().any(drive) || wrist.any(|(tau, max)| tau.abs() >= max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Input, Mode, Trajectory};
    use emla::Surrogate;
    use machine::Machine;

    /// Integral after `seconds` in steps of 1 ms beside the start pose, by 1e-4 rad in each joint.
    fn after(
        machine: &Machine,
        mode: Mode,
        integral: bool,
        seconds: f64,
    ) -> (Vector6<f64>, Errors) {
        let settings = Settings {
            mode,
            integral,
            ..Settings::of(&machine.controller)
        };
        let start = Input {
            zeta: machine.start.zeta,
            ..Input::default()
        };
        let network = Surrogate::reference();
        let mut controller =
            Controller::new(machine, &network, Trajectory::Cubic, &settings, &start, 0.0)
                .expect("valid");
        let beside = Input {
            zeta: start.zeta.map(|zeta| zeta + 1e-4),
            ..start
        };
        let now = controller.evaluate(&settings, &beside).expect("finite");
        for k in 0..(seconds / 1e-3) as u32 {
            let now = controller.evaluate(&settings, &beside).expect("finite");
            let t = f64::from(k) * 1e-3;
            controller
                .step(&now, &settings, &beside, t, 1e-3)
                .expect("finite");
        }
        (controller.state.integral, now.errors)
    }

    /// Closed form: the error stands still, so `z = ω e t`. Tolerance: one rounding a step.
    #[test]
    fn it_grows_with_the_error_in_the_modes_that_have_one() {
        let machine = Machine::reference();
        let (z, errors) = after(&machine, Mode::Pd, true, 0.05);
        let expected = errors.e * (machine.controller.omega_tip * 0.05);
        assert!(expected.norm() > 1e-5, "{expected}");
        assert!((z - expected).norm() < 50.0 * f64::EPSILON * expected.norm());
        assert_eq!(after(&machine, Mode::Pd, false, 0.05).0, Vector6::zeros());
    }

    #[test]
    fn it_rests_at_each_limit() {
        let nominal = Machine::reference();
        let mut machines = [nominal.clone(), nominal.clone(), nominal];
        machines[0].emla.lift.v_max = 1.0;
        machines[1].emla.lift.i_max = 1.0;
        machines[2].limits.tau_wrist_max[1] = 1.0;
        for machine in machines {
            let (z, _) = after(&machine, Mode::PdGravity, true, 0.05);
            assert_eq!(z, Vector6::zeros());
        }
    }
}
