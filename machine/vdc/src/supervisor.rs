//! The supervisor, run by `controller`: detects oscillations and overload and reacts in stages.
//!
//! Oscillation is measured for each rod as a power: the root mean square of the force error
//! `f_r − F` times that of the velocity error `ẋ_r − ẋ`, both band-passed around the boom's elastic
//! modes. Motion that follows the reference is in neither error. If the power exceeds the upper of
//! two thresholds, the adaptation is frozen; if it does not fall below the lower one in time, the
//! gains are lowered, then the joints are stopped along a ramp and held by the brakes. At eight times
//! the threshold the brakes are applied at once. A stage is never left backwards: the oscillation
//! would return.
//!
//! If the force of a rod stays at its limit and above its rating, the load is too heavy, and the
//! brakes are applied at once, as they are when a drive has tripped. A stopped machine becomes ready
//! again by a reset: gates on, brakes released, held where it stands.

mod cause;
mod monitors;
mod swing;

pub use cause::Cause;
pub(crate) use monitors::{Moment, Plausibility};

use crate::reference::Motion;
use crate::settings::Settings;
use crate::signals::Input;
use hdrm::DOF;
use machine_file::Controller as Gains;
use monitors::Monitors;
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use swing::{MEAN, Swing};

/// Upper threshold of the oscillation power over rated force times rated speed: 25 W on the
/// reference machine, where normal operation has up to 13 W and oscillation 35 W and more.
const UPPER: f64 = 5e-3;
/// Power over the upper threshold at which no more is waited for: a machine that runs away.
const RAGES: f64 = 8.0;
/// Lower threshold.
const LOWER: f64 = 1.6e-3;
/// Times to wait for the effect of freezing and lowering, s; a quarter of them if the power is four
/// times the upper threshold.
const PATIENCE: [f64; 2] = [1.0, 1.5];
/// Factor on the gains when lowered.
const LOWERED: f64 = 0.5;
/// Time in which the joints are stopped, s.
const RAMP: f64 = 0.5;
/// Closing time of a brake, during which the gates stay on, s.
pub(crate) const CLOSING: f64 = 0.05;
/// Time of overload after which the machine is stopped, s.
const OVERLOADED: f64 = 0.2;

/// Stages of the supervisor, in their order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Serialize, Deserialize)]
pub enum Stage {
    /// No supervision.
    #[default]
    Off,
    /// Normal operation, supervised.
    Watching,
    /// The adaptation is frozen.
    Frozen,
    /// The gains are lowered, too.
    Lowered,
    /// The joints are being stopped.
    Stopping,
    /// The brakes are applied, the gates still on.
    Braking,
    /// The brakes hold rods and wrist, the gates are off.
    Stopped,
}

/// What the supervisor is told in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observed {
    /// Errors of force, N, and velocity, m/s, of each rod.
    pub(crate) errors: [[f64; 2]; 3],
    /// Whether the force of a rod is at its limit and above its rating.
    pub(crate) is_overloaded: bool,
    /// A reason to apply the brakes at once.
    pub(crate) alarm: Option<Cause>,
    /// A rising edge makes a stopped machine ready again, unless there is an alarm or no supply.
    pub(crate) reset: bool,
    /// Whether the drives' supply is ready.
    pub(crate) is_supplied: bool,
}

impl Stage {
    /// Factor on the gains.
    fn gains(self) -> f64 {
        match self {
            Self::Off | Self::Watching | Self::Frozen => 1.0,
            Self::Lowered | Self::Stopping | Self::Braking | Self::Stopped => LOWERED,
        }
    }
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Supervisor {
    stage: Stage,
    /// Start time of the stage, s.
    since: f64,
    /// Whether a rod oscillates, with the hysteresis of both thresholds.
    swings: bool,
    /// Duration of the present overload, s.
    overloaded: f64,
    /// Oscillation of the force error, N, and velocity error, m/s, of each rod.
    errors: [[Swing; 2]; 3],
    /// Mean torques of the wrist joints, N·m; None before the first.
    wrist: Option<[f64; 3]>,
    /// Mean currents of the rods that hold their loads and stop their motors while a brake closes, A; None
    /// before the first.
    currents: Option<[f64; 3]>,
    /// The joints' reference from [`Stage::Stopping`] on.
    motion: Motion,
    /// Start time of the stop, s; after a reset as long as the reference is to rest.
    stop: Option<f64>,
    cause: Cause,
    /// The input `reset` of the step before.
    reset: bool,
    /// Whether the brakes are to be released after a reset.
    releases: bool,
    monitors: Monitors,
}

impl Supervisor {
    /// A supervisor that watches, or is off.
    pub(crate) fn new(watches: bool) -> Self {
        Self {
            stage: if watches { Stage::Watching } else { Stage::Off },
            ..Self::default()
        }
    }

    pub(crate) fn stage(&self) -> Stage {
        self.stage
    }

    /// Why it acts.
    pub(crate) fn cause(&self) -> Cause {
        self.cause
    }

    /// Start time of the stop, s.
    pub(crate) fn stop(&self) -> Option<f64> {
        self.stop
    }

    /// The joints' reference during and after the stop, and where they rest after a reset.
    pub(crate) fn motion(&self) -> Option<&Motion> {
        self.stop.map(|_| &self.motion)
    }

    /// `settings` with the gains of the present stage.
    pub(crate) fn effective_settings<'a>(&self, settings: &'a Settings) -> Cow<'a, Settings> {
        let factor = self.stage.gains();
        if factor == 1.0 {
            return Cow::Borrowed(settings);
        }
        let mut lowered = *settings;
        let gains = &mut lowered.gains;
        for gain in [
            &mut gains.Lambda_position,
            &mut gains.Lambda_orientation,
            &mut gains.kappa_KA,
            &mut gains.omega_tip,
            &mut gains.K_v,
            &mut gains.omega_d,
            &mut gains.pd_actuator_damping,
        ]
        .into_iter()
        .chain(&mut gains.pd_wrist_damping)
        {
            *gain *= factor;
        }
        Cow::Owned(lowered)
    }

    /// Forgets what swung so far, by gains for a payload that is not there.
    pub(crate) fn forget_swings(&mut self) {
        self.errors = Default::default();
    }

    /// Oscillation power of each rod over its rating `[N, m/s]`.
    fn powers(&self, ratings: &[[f64; 2]; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            let [force, rate] = self.errors[i].map(|error| error.square.sqrt());
            force * rate / (ratings[i][0] * ratings[i][1])
        })
    }

    /// The rod with the largest oscillation power, counted from 0, and that power, W.
    pub(crate) fn largest(&self, ratings: &[[f64; 2]; 3]) -> (usize, f64) {
        let powers = self.powers(ratings);
        let power = |i: usize| (i, powers[i] * ratings[i][0] * ratings[i][1]);
        (0..3)
            .map(power)
            .fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
    }

    /// Advances by `h` s from the time `t`, s. If a new stage begins, returns the ratio of the old to
    /// the new gains.
    pub(crate) fn advance(
        &mut self,
        observed: &Observed,
        ratings: &[[f64; 2]; 3],
        t: f64,
        h: f64,
    ) -> Option<f64> {
        let is_reset = observed.reset && !self.reset;
        self.reset = observed.reset;
        if self.stage >= Stage::Stopping {
            let left = (RAMP - (t - self.since)).max(0.0);
            self.motion.advance_to_rest(left, h);
        } else {
            let swings = self.errors.iter_mut().flatten();
            for (swing, error) in swings.zip(observed.errors.iter().flatten()) {
                swing.add(*error, h);
            }
            self.overloaded = if observed.is_overloaded {
                self.overloaded + h
            } else {
                0.0
            };
        }
        let power = self.powers(ratings).into_iter().fold(0.0, f64::max);
        self.swings = power > if self.swings { LOWER } else { UPPER };
        let hurry = if power > 4.0 * UPPER { 0.25 } else { 1.0 };
        let elapsed = t + h - self.since;
        let waited = |time: f64| elapsed >= time * (1.0 - 1e-9);
        let is_overloaded = (self.overloaded > OVERLOADED).then_some(Cause::Overload);
        let rages = (power > RAGES * UPPER).then_some(Cause::Swinging);
        let alarm = observed.alarm.or(is_overloaded).or(rages);
        let is_ready = observed.is_supplied && observed.alarm.is_none();
        let next = match self.stage {
            Stage::Watching | Stage::Frozen | Stage::Lowered | Stage::Stopping
                if alarm.is_some() =>
            {
                Stage::Braking
            }
            Stage::Stopped if is_reset && is_ready => Stage::Braking,
            Stage::Braking if self.releases && is_ready && waited(CLOSING) => Stage::Watching,
            Stage::Watching if self.swings => Stage::Frozen,
            Stage::Frozen if self.swings && waited(hurry * PATIENCE[0]) => Stage::Lowered,
            Stage::Lowered if self.swings && waited(hurry * PATIENCE[1]) => Stage::Stopping,
            Stage::Stopping if waited(RAMP) => Stage::Braking,
            Stage::Braking if waited(CLOSING) => Stage::Stopped,
            _ => return None,
        };
        let fall = self.stage.gains() / next.gains();
        self.cause = match next {
            Stage::Watching => Cause::None,
            Stage::Braking if self.stage == Stage::Stopped => Cause::None,
            Stage::Braking => alarm.unwrap_or(self.cause),
            Stage::Frozen => Cause::Swinging,
            _ => self.cause,
        };
        self.releases = self.stage == Stage::Stopped;
        (self.stage, self.since) = (next, t + h);
        Some(fall)
    }

    /// Which gates of rods and wrist stay on while the brakes close: not those of drives that do not
    /// do what they are told.
    pub(crate) fn gates(&self) -> [bool; 2 * 3] {
        match self.stage {
            Stage::Stopped => [false; 6],
            Stage::Braking => self.monitors.erring.map(|errs| !errs),
            _ => [true; 6],
        }
    }

    /// Advances the monitors by a step, unless the machine is braked, also for want of supply; the
    /// first cause for alarm. After a gap they begin anew.
    pub(crate) fn monitor(&mut self, at: Option<&Moment>) -> Option<Cause> {
        let watched = at.filter(|at| self.stage < Stage::Braking && !at.input.supply_missing);
        if let Some(at) = watched {
            let swings = self.swings && self.stage >= Stage::Lowered;
            return self.monitors.advance(at, swings);
        }
        // While brakes close, it is known which drives err.
        if self.stage != Stage::Braking {
            self.monitors = Monitors::default();
        }
        None
    }

    /// Averages the torques of the wrist, N·m, and the rods' currents, A, over `h` s; their means hold
    /// a payload of any mass.
    pub(crate) fn average_commands(&mut self, torques: &[f64; 3], currents: &[f64; 3], h: f64) {
        let share = -libm::expm1(-h / MEAN);
        for (means, values) in [(&mut self.wrist, torques), (&mut self.currents, currents)] {
            let means = means.get_or_insert(*values);
            for (mean, value) in means.iter_mut().zip(values) {
                *mean += share * (value - *mean);
            }
        }
    }

    /// Currents that hold and stop the rods while their brakes close, A, whatever sensors say; None unless
    /// they close for a stop.
    pub(crate) fn holding_currents(&self) -> Option<[f64; 3]> {
        let is_closing = self.stage == Stage::Braking && !self.releases;
        is_closing.then_some(self.currents).flatten()
    }

    /// Torque that holds wrist joint `j`, counted from 0, after the stop, N·m. `inertia` I is that
    /// of its own bodies, as the payload's is unknown:
    /// ```text
    /// τ = τ_mean + κ I (Λ (ζ_d − ζ) − ζ̇)
    /// ```
    pub(crate) fn wrist_holding_torque(
        &self,
        j: usize,
        inertia: f64,
        gains: &Gains,
        input: &Input,
    ) -> f64 {
        let error = self.motion.zeta[3 + j] - input.zeta[3 + j];
        let lacking = gains.Lambda_orientation * error - input.zeta_dot[3 + j];
        let mean = self.wrist.map_or(0.0, |mean| mean[j]);
        mean + gains.kappa_KA * inertia * lacking
    }

    /// Begins to stop the joints from `zeta`, rad, and the reference's `zeta_dot`, rad/s.
    pub(crate) fn begin_stop(&mut self, zeta: Vector6<f64>, zeta_dot: Vector6<f64>) {
        self.stop = Some(self.since);
        self.motion = Motion {
            zeta,
            zeta_dot,
            zeta_ddot: zeta_dot / -RAMP,
            ..Motion::default()
        };
    }

    /// Sets the rods' reference to the angles `zeta`, rad, at which they are braked.
    pub(crate) fn brake_at(&mut self, zeta: &[f64; DOF]) {
        self.motion = Motion {
            zeta: Vector6::from_fn(|i, _| if i < 3 { zeta[i] } else { self.motion.zeta[i] }),
            ..Motion::default()
        };
    }

    /// Rests at the angles `zeta`, rad, after a reset, and measures oscillations anew.
    pub(crate) fn stand_at(&mut self, zeta: &[f64; DOF]) {
        *self = Self {
            motion: Motion::rest(zeta),
            errors: Default::default(),
            swings: false,
            overloaded: 0.0,
            ..*self
        };
    }

    /// Follows the reference again, which begins where the machine stands.
    pub(crate) fn follow_reference(&mut self) {
        self.stop = None;
    }
}

#[cfg(test)]
mod tests;
