//! What may be changed while the controller runs.

use crate::law::Mode;
use crate::reference::RateCommand;
use machine_file::Controller as Gains;
use serde::{Deserialize, Serialize};

/// What the controller follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Level {
    /// The tip's reference, through inverse kinematics and decomposition, down to the voltages.
    Machine,
    /// References of the rods alone: each actuator by itself, as on a one-axis testbed.
    Actuator,
}

/// What may be changed while the controller runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Which control law is at work.
    pub mode: Mode,
    /// Whether the integral of the tip's error acts (at [`Level::Actuator`] of the rods' errors),
    /// at the rate `gains.omega_tip`.
    pub integral: bool,
    /// What is followed; not to be changed while the controller runs.
    pub level: Level,
    /// Gains.
    pub gains: Gains,
    /// Whether the drives regulate their currents themselves and follow
    /// [`crate::Output::i_q_required`]; otherwise they follow the voltages.
    pub current_loop: bool,
    /// Time after the start in which the payload is weighed at the wrist while nothing adapts, s; 0:
    /// the nominal payload counts.
    pub weighing_time: f64,
    /// Blending factor α of the hybrid actuator that the low-level law reckons with, 0…1; 0: it
    /// knows the physics only.
    pub alpha: f64,
    /// Inertia of the plant over nominal, for the Lyapunov outputs only.
    pub true_inertia_scale: f64,
    /// Largest required force of a rod over its rated one, for short times; 0: it has no limit but
    /// the currents'.
    pub force_limit: f64,
    /// Whether a supervisor watches for swinging; not to be changed while the controller runs, and
    /// without effect at [`Level::Actuator`].
    pub supervisor: bool,
    /// Less current for hot windings; None: `i_max` at any temperature.
    pub derating: Option<Derating>,
    /// Which rates are commanded, if the trajectory is [`crate::Trajectory::Rates`].
    pub rate_command: RateCommand,
    /// Whether the controller is told of the loads that a path picks up and sets down.
    pub load_known: bool,
}

impl Settings {
    /// The adaptive controller of the whole machine with these gains, which reckons with the
    /// physics alone and is told of loads; no integral, no derating.
    #[must_use]
    pub fn from_gains(gains: &Gains) -> Self {
        Self {
            mode: Mode::Adaptive,
            integral: false,
            level: Level::Machine,
            gains: *gains,
            current_loop: false,
            weighing_time: 0.0,
            alpha: 0.0,
            true_inertia_scale: 1.0,
            force_limit: 0.0,
            supervisor: false,
            derating: None,
            rate_command: RateCommand::Joint,
            load_known: true,
        }
    }
}

/// Currents fall with the winding's temperature: up to `start` the law asks for up to `i_max`, from
/// `end` on for nothing, in between for a share that falls linearly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Derating {
    /// Temperature from which on the current is reduced, K.
    pub start: f64,
    /// Temperature from which on there is none, K.
    pub end: f64,
}

impl Derating {
    /// Share of `i_max` at the winding temperature `T`, K.
    pub(crate) fn share(&self, T: f64) -> f64 {
        ((self.end - T) / (self.end - self.start)).clamp(0.0, 1.0)
    }
}
