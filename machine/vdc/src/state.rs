//! All that moves in the controller, one field a stage.

use crate::bodies::Bodies;
use crate::drive::DriveState;
use crate::measured::{JointObserver, Sampling};
use crate::reference::Motion;
use crate::supervisor::Supervisor;
use hdrm::DOF;
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

/// The controller's state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    /// Time that the states belong to, and with them the next evaluation, s: the communication
    /// point without `sample_time` and `delay`.
    pub(crate) t: f64,
    /// Time at which the controller started, s.
    pub(crate) t_start: f64,
    pub(crate) joints: JointObserver,
    pub(crate) sampling: Sampling,
    /// The joints' reference under commanded rates; at the start pose without.
    pub(crate) motion: Motion,
    /// Integral part z of the tracking error, in the places of [`crate::tracking::Errors`].
    pub(crate) integral: Vector6<f64>,
    /// What the control law integrates, a joint each.
    pub(crate) law_integral: [f64; DOF],
    pub(crate) bodies: Bodies,
    pub(crate) drives: [DriveState; 3],
    pub(crate) supervisor: Supervisor,
}

impl State {
    /// Time since the reference began to move, after a rest of `settle_time`, s; negative before.
    /// It stands still once the supervisor stops the machine.
    pub(crate) fn motion_time(&self, settle_time: f64) -> f64 {
        let t = self
            .supervisor
            .stop()
            .map_or(self.t, |stop| stop.min(self.t));
        t - self.t_start - settle_time
    }
}
