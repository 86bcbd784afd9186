//! How long the reference has stood still, for `controller`: after a while the machine is where it
//! may stay for long, and has the gains with which it rests at any pose.

use crate::reference::DesiredMotion;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Time for which the gains of a path stay, s: longer than the rest before a path.
const STAYS: f64 = 4.5;
/// Time in which they fall, and in which they return once the reference moves, s.
const FALLS: f64 = 0.5;
const RETURNS: f64 = 0.1;

/// The reference of the step before, and for how long it has stood still, s, at most until the gains
/// have fallen.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Standstill {
    last: Option<DesiredMotion>,
    time: f64,
}

impl Standstill {
    /// Share of the gains' fall, 0 to 1.
    pub(crate) fn share(&self) -> f64 {
        ((self.time - STAYS) / FALLS).max(0.0)
    }

    /// Advances by `h` s with the reference `desired` held.
    pub(crate) fn advance(&mut self, desired: &DesiredMotion, h: f64) {
        let stands = desired.velocity == Vector3::zeros()
            && desired.angular_velocity == Vector3::zeros()
            && self.last.as_ref() == Some(desired);
        self.last = Some(*desired);
        self.time = match self.share() {
            _ if stands => (self.time + h).min(STAYS + FALLS),
            0.0 => 0.0,
            _ => self.time - h * FALLS / RETURNS,
        };
    }
}
