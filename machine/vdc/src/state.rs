//! The state that `controller::step` advances: times, integrals, and the states of the stages.

use crate::bodies::Bodies;
use crate::drive::DriveState;
use crate::law::WristFriction;
use crate::measured::{JointObserver, Sampling};
use crate::reference::{Motion, Standstill};
use crate::supervisor::Supervisor;
use hdrm::DOF;
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    /// Time of the state and the next evaluation, s.
    pub(crate) t: f64,
    /// Time at which the controller started, s.
    pub(crate) t_start: f64,
    pub(crate) joints: JointObserver,
    pub(crate) sampling: Sampling,
    /// The joints' reference under commanded rates; otherwise the start pose.
    pub(crate) motion: Motion,
    pub(crate) standstill: Standstill,
    /// Integral part z of the tracking error, in the order of [`crate::tracking::Errors`].
    pub(crate) integral: Vector6<f64>,
    /// Integral of the control law for each joint.
    pub(crate) law_integral: [f64; DOF],
    pub(crate) wrist_friction: WristFriction,
    pub(crate) bodies: Bodies,
    pub(crate) drives: [DriveState; 3],
    pub(crate) supervisor: Supervisor,
}

impl State {
    /// Time since the reference started to move, after a rest of `settle_time`, s; negative before.
    /// It is constant once the supervisor stops the machine.
    pub(crate) fn motion_time(&self, settle_time: f64) -> f64 {
        let t = self
            .supervisor
            .stop()
            .map_or(self.t, |stop| stop.min(self.t));
        t - self.t_start - settle_time
    }
}
