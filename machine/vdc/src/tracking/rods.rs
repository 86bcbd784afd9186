//! Required motion of the rods, for `controller`: from their own references (as on a one-axis
//! testbed) or from the required motion of the joints.

use crate::signals::Input;
use crate::tracking::errors::Errors;
use crate::tracking::required::{RequiredMotion, RodMotion};
use hdrm::Stroke;
use machine_file::Controller as Gains;
use nalgebra::Vector6;

/// Desired minus measured rod positions, m (first three elements); `age`, s, old.
pub(crate) fn rod_errors(input: &Input, age: f64) -> Vector6<f64> {
    let error = |i: usize| {
        input.reference_rod_position[i] - age * input.reference_rod_velocity[i] - input.x[i]
    };
    Vector6::from_fn(|i, _| if i < 3 { error(i) } else { 0.0 })
}

impl RodMotion {
    /// Required motion of rod `i` to follow its own reference:
    /// ```text
    /// ẋ_r = ẋ_d + λ (x_d − x),   ẍ_r = ẍ_d + λ (ẋ_d − ẋ)
    /// ```
    /// Source: [Eq:Required_Joint_Velocity] for a prismatic joint. The integral z of the error and
    /// its rate z' are added to the errors of position and velocity, as for the tip.
    pub(crate) fn from_rod_reference(
        gains: &Gains,
        input: &Input,
        Errors { e, z, z_dot }: &Errors,
        i: usize,
    ) -> Self {
        let x_d_dot = input.reference_rod_velocity[i];
        let lambda = gains.Lambda_rod;
        Self {
            x_r_dot: x_d_dot + lambda * (e[i] + z[i]),
            x_r_ddot: input.reference_rod_acceleration[i]
                + lambda * (x_d_dot - input.x_dot[i] + z_dot[i]),
        }
    }

    /// Required motion of the rod of joint `i` with its `stroke`: `ẋ_r = x'·ζ̇_r`,
    /// `ẍ_r = x'·ζ̈_r + x''·ζ̇·ζ̇_r`.
    pub(crate) fn from_joint(
        stroke: &Stroke,
        zeta_dot: f64,
        required: &RequiredMotion,
        i: usize,
    ) -> Self {
        let rate_r = required.zeta_dot[i];
        Self {
            x_r_dot: stroke.prime * rate_r,
            x_r_ddot: stroke.prime * required.zeta_ddot[i] + stroke.second * zeta_dot * rate_r,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::Machine;

    /// The equations in numbers whose parts are told apart by their powers of ten.
    #[test]
    fn a_required_motion_has_all_its_parts() {
        let mut gains = Machine::reference().controller;
        gains.Lambda_rod = 10.0;
        let input = Input {
            x_dot: [0.0, 0.25, 0.0],
            reference_rod_velocity: [0.0, 0.5, 0.0],
            reference_rod_acceleration: [0.0, 8.0, 0.0],
            ..Input::default()
        };
        let one = |value: f64| Vector6::from_fn(|i, _| if i == 1 { value } else { 0.0 });
        let errors = Errors {
            e: one(0.0625),
            z: one(-0.03125),
            z_dot: one(1.5),
        };
        let RodMotion { x_r_dot, x_r_ddot } =
            RodMotion::from_rod_reference(&gains, &input, &errors, 1);
        assert_eq!(x_r_dot, 0.5 + 10.0 * 0.03125);
        assert_eq!(x_r_ddot, 8.0 + 10.0 * (0.25 + 1.5));
    }

    #[test]
    fn errors_are_those_of_the_time_of_the_reading() {
        let input = Input {
            reference_rod_position: [1.0, 2.0, 3.0],
            reference_rod_velocity: [0.5, 0.25, -0.5],
            x: [0.5, 2.5, 3.0],
            ..Input::default()
        };
        let e = rod_errors(&input, 0.5);
        assert_eq!(e, Vector6::new(0.25, -0.625, 0.25, 0.0, 0.0, 0.0));
    }
}
