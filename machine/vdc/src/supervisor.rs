//! The supervisor, run by `controller`: detects oscillations and overload and reacts in stages.
//!
//! Oscillation is measured for each rod as a power: the root mean square of the force error
//! `f_r − F` times that of the velocity error `ẋ_r − ẋ`, both band-passed around the boom's elastic
//! modes. Motion that follows the reference is in neither error. If the power exceeds the upper of
//! two thresholds, the adaptation is frozen; if it does not fall below the lower one in time, the
//! gains are lowered, then the joints are stopped along a ramp and held by the brakes. A stage is
//! never left backwards: the oscillation would return.
//!
//! If the force of a rod stays at its limit and above its rating, the load is too heavy, and the
//! brakes are applied at once, as they are when a drive has tripped. A stopped machine becomes ready
//! again by a reset: gates on, brakes released, held where it stands.

mod cause;
mod monitors;
mod swing;

pub use cause::Cause;
pub(crate) use monitors::Plausibility;

use crate::nominal::Nominal;
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
const CLOSING: f64 = 0.05;
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
        let alarm = observed.alarm.or(is_overloaded);
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

    /// Advances the monitors by `h` s with the measurements `input` and what belongs to them, `now`,
    /// unless the machine is braked; the first cause for alarm.
    pub(crate) fn monitor(
        &mut self,
        now: &Plausibility,
        nominal: &Nominal,
        settings: &Settings,
        input: &Input,
        h: f64,
    ) -> Option<Cause> {
        if self.stage < Stage::Braking {
            return self.monitors.advance(now, nominal, settings, input, h);
        }
        self.monitors = Monitors::default();
        None
    }

    /// Averages the wrist torques, N·m, over `h` s; the mean holds a payload of any mass.
    pub(crate) fn average_wrist_torques(&mut self, torques: &[f64; 3], h: f64) {
        let mean = self.wrist.get_or_insert(*torques);
        for (mean, torque) in mean.iter_mut().zip(torques) {
            *mean -= libm::expm1(-h / MEAN) * (torque - *mean);
        }
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
mod tests {
    use super::swing::BAND;
    use super::*;
    use machine_file::Machine;
    use std::f64::consts::TAU;

    const H: f64 = 1e-3;
    const RATINGS: [[f64; 2]; 3] = [[70e3, 0.07]; 3];
    const QUIET: Observed = Observed {
        errors: [[0.0; 2]; 3],
        is_overloaded: false,
        alarm: None,
        reset: false,
        is_supplied: true,
    };

    /// Root mean square of what passes of a sine of amplitude 1 at `f` Hz.
    fn passed(f: f64) -> f64 {
        let mut swing = Swing::default();
        for k in 0..10_000 {
            swing.add((TAU * f * H * f64::from(k)).sin(), H);
        }
        swing.square.sqrt()
    }

    /// Closed form of two high-passes and a low-pass of first order; tolerance: half the
    /// ripple of the mean square, 1/(2·2π·f·0.3 s) of it, and 1 % for half a sample's phase.
    #[test]
    fn what_swings_is_what_lies_in_the_band() {
        for f in [3.0, 5.6, 9.0] {
            let [low, high] = BAND;
            let gain = f * f / (f * f + low * low) / (1.0 + (f / high).powi(2)).sqrt();
            let expected = gain / 2.0_f64.sqrt();
            let found = passed(f);
            assert!(
                (found / expected - 1.0).abs() < 0.5 / (2.0 * TAU * f * MEAN) + 0.01,
                "{f} Hz: {found}, {expected}"
            );
        }
        assert!(passed(0.3) < 0.03, "{}", passed(0.3));
    }

    /// Advances for `seconds` with errors of force and velocity whose amplitudes have the power
    /// `share` of the rated one; what began, and when.
    fn run(watch: &mut Supervisor, from: f64, seconds: f64, share: f64) -> Vec<(Stage, f64)> {
        let mut begun = Vec::new();
        // Of 5.6 Hz passes 0.855, twice; a product of amplitudes is twice that of its roots.
        let size = (2.0 * share).sqrt() / 0.855;
        for k in 0..(seconds / H) as u32 {
            let t = from + H * f64::from(k);
            let wave = size * (TAU * 5.6 * t).sin();
            let errors = [[0.0; 2], RATINGS[1].map(|rated| wave * rated), [0.0; 2]];
            let observed = Observed { errors, ..QUIET };
            if watch.advance(&observed, &RATINGS, t, H).is_some() {
                begun.push((watch.stage(), t + H));
            }
        }
        begun
    }

    /// An action after the other, each after the time that the one before was given; the stop along
    /// the ramp and the closing of the brakes take their own times.
    #[test]
    fn what_goes_on_swinging_is_stopped_step_by_step() {
        let mut watch = Supervisor::new(true);
        let begun = run(&mut watch, 0.0, 8.0, 2.0 * UPPER);
        let stages: Vec<Stage> = begun.iter().map(|(stage, _)| *stage).collect();
        let expected = [
            Stage::Frozen,
            Stage::Lowered,
            Stage::Stopping,
            Stage::Braking,
            Stage::Stopped,
        ];
        assert_eq!(stages, expected);
        for (k, time) in [PATIENCE[0], PATIENCE[1], RAMP, CLOSING]
            .into_iter()
            .enumerate()
        {
            let waited = begun[k + 1].1 - begun[k].1;
            assert!(
                (waited - time).abs() < 1.5 * H,
                "{stages:?} {k}: {waited} s"
            );
        }
        // The more it swings, the faster.
        let begun = run(&mut Supervisor::new(true), 0.0, 2.0, 20.0 * UPPER);
        let waited = begun[1].1 - begun[0].1;
        assert!((waited - 0.25 * PATIENCE[0]).abs() < 1.5 * H, "{waited} s");
    }

    #[test]
    fn what_no_longer_swings_is_left_as_it_is() {
        let mut watch = Supervisor::new(true);
        assert_eq!(run(&mut watch, 0.0, 5.0, 0.8 * UPPER), []);
        assert_eq!(watch.stage(), Stage::Watching);
        let mut t = 0.0;
        while watch.stage() == Stage::Watching {
            run(&mut watch, t, 0.1, 2.0 * UPPER);
            t += 0.1;
        }
        // Between both thresholds it still swings, below the lower one no longer.
        let mut other = watch;
        assert_eq!(run(&mut watch, t, 9.0, 0.3 * LOWER), []);
        assert_eq!(watch.stage(), Stage::Frozen);
        assert_eq!(run(&mut other, t, 9.0, 0.8 * UPPER).len(), 4);
        let mut off = Supervisor::new(false);
        assert_eq!(run(&mut off, 0.0, 5.0, 50.0 * UPPER), []);
    }

    /// A rod that keeps its largest force is braked at once, however steady it is.
    #[test]
    fn a_load_beyond_the_machine_is_braked() {
        let mut watch = Supervisor::new(true);
        let mut steps = 0;
        while watch.stage() == Stage::Watching {
            let observed = Observed {
                errors: [[7e3, 0.0]; 3],
                is_overloaded: true,
                ..QUIET
            };
            watch.advance(&observed, &RATINGS, H * f64::from(steps), H);
            steps += 1;
        }
        assert_eq!(watch.stage(), Stage::Braking);
        assert!(
            (H * f64::from(steps) - OVERLOADED).abs() < 1.5 * H,
            "{steps}"
        );
    }

    /// A trip is braked at once, also during a stop along the ramp; a reset works by its rising edge,
    /// once the trip is over and the supply is there, and opens the brakes after their closing time.
    #[test]
    fn a_trip_brakes_and_a_reset_makes_ready_again() {
        let tripped = Observed {
            alarm: Some(Cause::Tripped),
            ..QUIET
        };
        let reset = Observed {
            reset: true,
            ..QUIET
        };
        let mut watch = Supervisor::new(true);
        let mut k = 0;
        let mut steps = |watch: &mut Supervisor, observed: Observed, n: u32| {
            for _ in 0..n {
                watch.advance(&observed, &RATINGS, H * f64::from(k), H);
                k += 1;
            }
            (watch.stage(), watch.cause())
        };
        assert_eq!(
            steps(&mut watch, tripped, 1),
            (Stage::Braking, Cause::Tripped)
        );
        assert_eq!(
            steps(&mut watch, tripped, 60),
            (Stage::Stopped, Cause::Tripped)
        );
        let early = Observed {
            reset: true,
            ..tripped
        };
        assert_eq!(steps(&mut watch, early, 60).0, Stage::Stopped);
        // Held since, it is no edge.
        assert_eq!(steps(&mut watch, reset, 60).0, Stage::Stopped);
        steps(&mut watch, QUIET, 1);
        let dead = Observed {
            is_supplied: false,
            ..reset
        };
        assert_eq!(steps(&mut watch, dead, 5).0, Stage::Stopped);
        steps(&mut watch, QUIET, 1);
        assert_eq!(steps(&mut watch, reset, 1), (Stage::Braking, Cause::None));
        assert_eq!(steps(&mut watch, reset, 40).0, Stage::Braking);
        assert_eq!(steps(&mut watch, reset, 20), (Stage::Watching, Cause::None));
        let mut stopping = Supervisor {
            stage: Stage::Stopping,
            ..watch
        };
        assert_eq!(steps(&mut stopping, tripped, 1).0, Stage::Braking);
    }

    #[test]
    fn gains_are_those_asked_for_until_they_are_lowered() {
        let settings = Settings::from_gains(&Machine::reference().controller);
        let at = |stage| Supervisor {
            stage,
            ..Supervisor::default()
        };
        for stage in [Stage::Off, Stage::Watching, Stage::Frozen] {
            assert!(matches!(
                at(stage).effective_settings(&settings),
                Cow::Borrowed(_)
            ));
        }
        let asked = &settings.gains;
        let lowered = at(Stage::Lowered).effective_settings(&settings).gains;
        assert_eq!(lowered.Lambda_position, 0.5 * asked.Lambda_position);
        assert_eq!(lowered.kappa_KA, 0.5 * asked.kappa_KA);
        assert_eq!(lowered.K_v, 0.5 * asked.K_v);
        assert_eq!(lowered.K_i, asked.K_i);
    }

    /// The joints come to rest along a ramp: half the way that they would have gone.
    #[test]
    fn the_joints_come_to_rest_in_half_the_way() {
        let mut watch = Supervisor {
            stage: Stage::Stopping,
            ..Supervisor::default()
        };
        let [zeta, rate] = [0.3, -0.2].map(Vector6::repeat);
        watch.begin_stop(zeta, rate);
        run(&mut watch, 0.0, RAMP, 0.0);
        let Motion {
            zeta: end,
            zeta_dot,
            zeta_ddot,
            ..
        } = watch.motion;
        assert!((end - (zeta + rate * (0.5 * RAMP))).norm() < 1e-12, "{end}");
        assert_eq!((zeta_dot, zeta_ddot), (Vector6::zeros(), Vector6::zeros()));
    }

    /// The wrist is held by the mean of a torque that swings, and by its own inertia.
    #[test]
    fn the_wrist_is_held_by_what_held_it_on_average() {
        let mut watch = Supervisor::default();
        for k in 0..3000 {
            let wave = 900.0 * (TAU * 7.0 * H * f64::from(k)).sin();
            watch.average_wrist_torques(&[150.0 + wave, -90.0, 5.0], H);
        }
        watch.motion.zeta[5] = 0.2;
        let mut gains = Machine::reference().controller;
        (gains.kappa_KA, gains.Lambda_orientation) = (8.0, 3.0);
        let mut input = Input::default();
        (input.zeta[5], input.zeta_dot[5]) = (0.15, -0.4);
        let of = |j| watch.wrist_holding_torque(j, 0.5, &gains, &input);
        // What is left of the wave: 1/(2π·7·0.3) of it.
        assert!((of(0) - 150.0).abs() < 900.0 / 13.0, "{}", of(0));
        assert!((of(1) + 90.0).abs() < 1e-9);
        assert!((of(2) - (5.0 + 8.0 * 0.5 * (3.0 * 0.05 + 0.4))).abs() < 1e-9);
    }
}
