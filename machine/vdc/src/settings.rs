//! Settings that the FMU gives the controller in every step: mode, gains, limits, options.

use crate::law::Mode;
use crate::reference::RateCommand;
use machine_file::Controller as Gains;
use serde::{Deserialize, Serialize};

/// The level at which the controller works.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Level {
    /// The whole machine: from the tip's reference to the voltages.
    Machine,
    /// Single actuators: each rod follows its own reference, as on a one-axis testbed.
    Actuator,
}

/// Settings of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The control law.
    pub mode: Mode,
    /// Whether the integral of the tip's error acts (at [`Level::Actuator`] of the rods' errors),
    /// at the rate `gains.omega_tip`.
    pub integral: bool,
    /// The level; constant while the controller runs.
    pub level: Level,
    /// Gains.
    pub gains: Gains,
    /// Whether the drives regulate their currents themselves and follow
    /// [`crate::Output::i_q_required`]; otherwise they follow the voltages.
    pub current_loop: bool,
    /// Time after the start in which the payload is weighed at the wrist instead of adaptation, s;
    /// 0: the nominal payload is used.
    pub weighing_time: f64,
    /// γ, the share of the tip's error of a lap that is met in the next one; 0: nothing is learnt.
    pub learning: f64,
    /// Blending factor α of the network in the nominal actuator model, 0…1; 0: physics only.
    pub alpha: f64,
    /// Inertia of the plant over nominal, for the Lyapunov outputs only.
    pub true_inertia_scale: f64,
    /// Largest required force of a rod over its rated one; 0: only currents are limited.
    pub force_limit: f64,
    /// Whether a supervisor watches for oscillations; constant while the controller runs, and
    /// without effect at [`Level::Actuator`].
    pub supervisor: bool,
    /// Reduction of the current for hot windings; None: `i_max` at any temperature.
    pub derating: Option<Derating>,
    /// Which rates are commanded, if the trajectory is [`crate::Trajectory::Rates`].
    pub rate_command: RateCommand,
    /// Whether the controller knows the loads that a path picks up and sets down.
    pub load_known: bool,
}

impl Settings {
    /// The paper's adaptive controller with these gains; loads known, other options off.
    #[must_use]
    pub fn from_gains(gains: &Gains) -> Self {
        Self {
            mode: Mode::Adaptive,
            integral: false,
            level: Level::Machine,
            gains: *gains,
            current_loop: false,
            weighing_time: 0.0,
            learning: 0.0,
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

/// Reduction of the largest current with the winding's temperature: `i_max` up to `start`, 0 from
/// `end` on, linear in between.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Derating {
    /// Temperature above which the current is reduced, K.
    pub start: f64,
    /// Temperature above which the current is 0, K.
    pub end: f64,
}

impl Derating {
    /// Share of `i_max` at the winding temperature `T`, K.
    pub(crate) fn share(&self, T: f64) -> f64 {
        ((self.end - T) / (self.end - self.start)).clamp(0.0, 1.0)
    }
}
