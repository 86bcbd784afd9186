//! The required motion of joints and rods, the input of the control laws and the voltage law.

use nalgebra::Vector6;

/// Required joint rates and accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RequiredMotion {
    /// `zeta_dot_r`, rad/s.
    pub(crate) zeta_dot: Vector6<f64>,
    /// `zeta_ddot_r`, rad/s².
    pub(crate) zeta_ddot: Vector6<f64>,
}

/// Required motion of a rod.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RodMotion {
    /// Velocity, m/s.
    pub(crate) x_r_dot: f64,
    /// Acceleration, m/s².
    pub(crate) x_r_ddot: f64,
}
