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
