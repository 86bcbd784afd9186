//! The actuator level alone: each rod follows a reference of its own, as on a one-axis testbed.
//!
//! It is the decomposition of a machine with a single body, the rod, moved by one prismatic joint;
//! what the level of the machine asks of the voltage law comes from here instead.

use crate::integral::Errors;
use crate::low_level::RodDemand;
use crate::{Input, Mode, Settings};
use nalgebra::Vector6;

/// Demand on rod `i` with the nominal mass `M_act`, kg.
/// ```text
/// ẋ_r = ẋ_d + λ (x_d − x),   ẍ_r = ẍ_d + λ (ẋ_d − ẋ)
/// f_r = f_d + M_act ẍ_r + K_A (ẋ_r − ẋ),   K_A = kappa_KA·M_act
/// ```
/// Source: [Eq:Required_Joint_Velocity] for a prismatic joint, and [Eq:Required_Force] with the rod
/// as the body; `f_d` is the force on the load. In the modes without model damping takes its place. The integral z of the error and its
/// rate z' are added to the errors of position and velocity, as in [`crate::clik::required`].
pub(crate) fn demand(
    M_act: f64,
    settings: &Settings,
    input: &Input,
    Errors { e, z, z_dot }: &Errors,
    i: usize,
) -> RodDemand {
    let gains = &settings.gains;
    let x_dot = input.x_dot[i];
    let x_d_dot = input.reference_rod_velocity[i];
    let lambda = gains.Lambda_rod;
    let x_r_dot = x_d_dot + lambda * (e[i] + z[i]);
    let x_r_ddot = input.reference_rod_acceleration[i] + lambda * (x_d_dot - x_dot + z_dot[i]);
    let f_r = match settings.mode {
        Mode::Adaptive | Mode::Modular => {
            input.reference_rod_force[i] + M_act * (x_r_ddot + gains.kappa_KA * (x_r_dot - x_dot))
        }
        Mode::Pd => gains.pd_actuator_damping * (x_r_dot - x_dot),
        Mode::PdGravity => {
            input.reference_rod_force[i] + gains.pd_actuator_damping * (x_r_dot - x_dot)
        }
    };
    RodDemand {
        f_r,
        x_r_dot,
        x_r_ddot,
    }
}

/// Desired minus measured rod positions, m, where the measurements are `age` old, s; in the first three places.
pub(crate) fn errors(input: &Input, age: f64) -> Vector6<f64> {
    let error = |i: usize| {
        input.reference_rod_position[i] - age * input.reference_rod_velocity[i] - input.x[i]
    };
    Vector6::from_fn(|i, _| if i < 3 { error(i) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Level;
    use machine::Machine;

    /// The equations in numbers whose parts are told apart by their powers of ten.
    #[test]
    fn a_demand_has_all_its_parts() {
        let mut gains = Machine::reference().controller;
        (gains.Lambda_rod, gains.kappa_KA) = (10.0, 3.0);
        gains.pd_actuator_damping = 5.0;
        let input = Input {
            x_dot: [0.0, 0.25, 0.0],
            reference_rod_velocity: [0.0, 0.5, 0.0],
            reference_rod_acceleration: [0.0, 8.0, 0.0],
            reference_rod_force: [0.0, 4096.0, 0.0],
            ..Input::default()
        };
        let one = |value: f64| Vector6::from_fn(|i, _| if i == 1 { value } else { 0.0 });
        let errors = Errors {
            e: one(0.0625),
            z: one(-0.03125),
            z_dot: one(1.5),
        };
        let of = |mode| {
            let settings = Settings {
                mode,
                integral: true,
                level: Level::Actuator,
                ..Settings::of(&gains)
            };
            demand(16.0, &settings, &input, &errors, 1)
        };
        for mode in [Mode::Adaptive, Mode::Modular, Mode::Pd, Mode::PdGravity] {
            let RodDemand {
                f_r,
                x_r_dot,
                x_r_ddot,
            } = of(mode);
            assert_eq!(x_r_dot, 0.5 + 10.0 * 0.03125);
            assert_eq!(x_r_ddot, 8.0 + 10.0 * (0.25 + 1.5));
            let lacking = 0.5 + 10.0 * 0.03125 - 0.25;
            let expected = match mode {
                Mode::Pd => 5.0 * lacking,
                Mode::PdGravity => 4096.0 + 5.0 * lacking,
                _ => 4096.0 + 16.0 * 25.5 + 16.0 * 3.0 * lacking,
            };
            assert_eq!(f_r, expected, "{mode:?}");
        }
    }

    #[test]
    fn errors_are_those_of_the_time_of_the_reading() {
        let input = Input {
            reference_rod_position: [1.0, 2.0, 3.0],
            reference_rod_velocity: [0.5, 0.25, -0.5],
            x: [0.5, 2.5, 3.0],
            ..Input::default()
        };
        let e = errors(&input, 0.5);
        assert_eq!(e, Vector6::new(0.25, -0.625, 0.25, 0.0, 0.0, 0.0));
    }
}
