//! Inputs of the FMU `Hdrm`: rod forces, wrist torques, external wrench, motion of the base.

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};
use spatial::Wrench;

/// Inputs of the manipulator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Actuator forces of slew, lift and tilt, N, positive when extending.
    pub f: [f64; 3],
    /// Wrist torques, N·m; saturated to the machine's limits.
    pub tau_wrist: [f64; 3],
    /// Wrench `[f; m]` of the environment on the end-effector at T4 in T4 axes, N and N·m.
    pub wrench_env: [f64; 6],
    /// Acceleration of the base in the machine's world axes, m/s².
    pub base_acceleration: [f64; 3],
    /// Tilt of the base, rad: roll about x, then pitch about its own z.
    pub base_tilt: [f64; 2],
    /// Angular velocity of the base in the machine's world axes, rad/s.
    pub base_angular_velocity: [f64; 3],
    /// Angular acceleration of the base in those axes, rad/s².
    pub base_angular_acceleration: [f64; 3],
    /// Whether the wrist's drives give torque.
    pub wrist_enable: [bool; 3],
    /// Whether the wrist's brakes are applied.
    pub wrist_brake: [bool; 3],
}

impl Default for Input {
    fn default() -> Self {
        Self {
            f: [0.0; 3],
            tau_wrist: [0.0; 3],
            wrench_env: [0.0; 6],
            base_acceleration: [0.0; 3],
            base_tilt: [0.0; 2],
            base_angular_velocity: [0.0; 3],
            base_angular_acceleration: [0.0; 3],
            wrist_enable: [true; 3],
            wrist_brake: [false; 3],
        }
    }
}

pub(crate) fn wrench(components: &[f64; 6]) -> Wrench {
    Wrench::from_vector(&Vector6::from(*components))
}
