//! What every control law computes, and from what.

use crate::bodies::Bodies;
use crate::law::decomposition::{BodyMotion, VelocityErrors};
use crate::nominal::Nominal;
use crate::tracking::{RequiredMotion, RodMotion};
use hdrm::{Body, Configuration, DOF};
use machine::Controller as Gains;

/// From required motion to forces.
pub(crate) trait ControlLaw: Sync {
    /// What rods and wrist joints of the whole machine are to give.
    fn forces(&self, now: &Instant) -> Forces;

    /// What one rod by itself is to give to its load, N.
    fn rod_force(&self, rod: &Rod) -> f64;

    /// Whether the drives compute their currents by the model of the actuator, with its inertia,
    /// friction and what the disturbance observer finds; otherwise by the lossless transmission.
    fn knows_actuators(&self) -> bool;

    /// Advances what the law learns of the bodies by `h` s with these motions held.
    fn learn(
        &self,
        _bodies: &mut Bodies,
        _motions: &[BodyMotion; Body::COUNT],
        _gains: &Gains,
        _h: f64,
    ) {
    }
}

/// The whole machine at one instant.
pub(crate) struct Instant<'a> {
    pub(crate) nominal: &'a Nominal,
    pub(crate) bodies: &'a Bodies,
    pub(crate) gains: &'a Gains,
    pub(crate) configuration: &'a Configuration,
    /// Measured joint rates, rad/s.
    pub(crate) zeta_dot: &'a [f64; DOF],
    pub(crate) required: &'a RequiredMotion,
    /// Required motion of the rods.
    pub(crate) rods: &'a [RodMotion; 3],
    /// Motion of what the machine stands on.
    pub(crate) ground: &'a BodyMotion,
    pub(crate) motions: &'a [BodyMotion; Body::COUNT],
    pub(crate) errors: &'a VelocityErrors,
}

/// One rod by itself at one instant.
pub(crate) struct Rod<'a> {
    pub(crate) gains: &'a Gains,
    /// Nominal mass that the actuator moves, kg.
    pub(crate) M_act: f64,
    pub(crate) required: &'a RodMotion,
    /// Measured velocity, m/s.
    pub(crate) x_dot: f64,
    /// Desired force on the load, N.
    pub(crate) f_d: f64,
}

/// What a law asks for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forces {
    /// Of the rods, N.
    pub(crate) rods: [f64; 3],
    /// Torques of the wrist joints, N·m, not yet held to their limits.
    pub(crate) wrist: [f64; 3],
}
