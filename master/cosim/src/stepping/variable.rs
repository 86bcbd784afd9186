//! Communication steps of variable length for `Steps`, chosen by the error of the step before, and
//! steps that are repeated from a saved state: because their error was too large or a component
//! stopped within them.

use anyhow::{Result, bail, ensure};
use fmi_description::{Access, Variability, Variable};

use super::controller::{StepControl, StepController, StepLimits};
use crate::instance::{At, Stopped};
use crate::master::{LastStep, Master};
use crate::structure::system::System;
use fmi_import::digits::short;

/// Repetitions of a step after which the run fails.
const REPEATS: usize = 100;

/// Part of its first length below which a step that a component stops is not shortened further: a
/// step that is too short to move the time would be repeated for ever.
const LEAST_PART: f64 = 1e-9;

/// Error above which a step that is chosen by energy is repeated, if repetition is on: the
/// controller holds errors near 1.
const TOO_LARGE: f64 = 2.0;

/// Numbers and lengths of the steps of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepCount {
    /// Steps that the run is made of.
    pub made: u64,
    /// Steps that were computed, including those repeated or made for comparison.
    pub computed: u64,
    /// Shortest and longest step of the run except the last, s.
    pub lengths: Option<[f64; 2]>,
}

/// The communication steps of a run, of variable length.
pub struct VariableSteps {
    control: StepControl,
    pub(super) controller: StepController,
    /// Stop time, s.
    pub(super) stop: f64,
    /// Numbers and lengths of the steps so far.
    pub(super) count: StepCount,
    /// Energy residual and turnover of each bond before the step, J.
    before: Vec<[f64; 2]>,
    /// Outputs after one whole step, for comparison with two halves.
    whole: Vec<f64>,
    /// Nominal value of each connected output that is compared; infinite for the others.
    nominal: Vec<f64>,
}

impl VariableSteps {
    /// The steps of `master`, which runs `system`, to `stop`, s.
    ///
    /// # Errors
    /// Control by energy without a power bond; limits or a tolerance that make no sense; a delay,
    /// which counts steps of one length; repeated steps of components that cannot save their state.
    pub fn new(system: &System, master: &Master, stop: f64, control: &StepControl) -> Result<Self> {
        let (step, start) = (master.stepping().step, master.time());
        ensure!(
            stop > start && stop.is_finite(),
            "the stop time {} s must be after the start, {} s",
            short(stop),
            short(start)
        );
        if let Some(delay) = master.exchange().faults.as_ref().and_then(|f| f.delay()) {
            let delay = short(delay);
            bail!("a delay of {delay} s needs communication steps of one length");
        }
        use StepControl::{Doubling, Energy, Fixed, Repeated};
        let (tolerance, mut limits) = match *control {
            Fixed | Repeated => (1.0, StepLimits::default()),
            Energy {
                tolerance: t,
                limits,
                ..
            }
            | Doubling {
                tolerance: t,
                limits,
            } => (t, limits),
        };
        match control {
            Fixed | Repeated => limits.length = [step; 2],
            // The error of a step grows with the square of its length.
            Doubling { .. } => (limits.proportional, limits.integral) = (0.0, 0.5),
            Energy { .. } => {}
        }
        ensure!(
            tolerance > 0.0 && tolerance.is_finite(),
            "tolerance {tolerance} of the communication steps must be greater than 0"
        );
        let remembers = matches!(control, Energy { .. });
        let mut first = step;
        if let Energy { scale, .. } = *control {
            // A first step that is too long would be noticed only after it.
            first = limits.length[0];
            ensure!(
                scale > 0.0 && scale.is_finite(),
                "the energy scale {scale} J must be greater than 0"
            );
            ensure!(
                !master.residuals().is_empty(),
                "the communication step cannot be chosen by energy: the system has no power bond"
            );
        }
        if control.repeats() {
            // Refuses now rather than in the middle of the run.
            master.save()?;
            master.stop_early();
        }
        let exchange = master.exchange();
        let is_compared = |v: &&Variable| {
            let is_real = matches!(v.access(), Access::Real | Access::Float32);
            is_real && v.variability == Variability::Continuous
        };
        let nominal = (0..exchange.values.len()).map(|slot| {
            let v = exchange.output(slot).map(|port| system.variable(port));
            let v = v.filter(is_compared);
            v.map_or(f64::INFINITY, |v| v.nominal.unwrap_or(1.0).abs())
        });
        Ok(Self {
            controller: StepController::new(limits, first, remembers)?,
            control: *control,
            stop,
            count: StepCount::default(),
            before: vec![[0.0; 2]; master.residuals().len()],
            whole: Vec::new(),
            nominal: nominal.collect(),
        })
    }

    /// Number of steps that are made, and of all if the rest are as long as the next.
    pub fn so_far(&self, master: &Master) -> (u64, u64) {
        let rest = ((self.stop - master.time()) / self.controller.state.next).ceil();
        (self.count.made, self.count.made + rest as u64)
    }

    /// Makes a step.
    pub fn make(&mut self, master: &mut Master) -> Result<()> {
        let start = master.time();
        let error = match self.control.repeats() {
            true => self.repeated(master)?,
            false => {
                let end = self.controller.end(start, self.stop);
                self.step_to(master, end)?;
                let error = self.error(master);
                self.controller.follow(end - start, error)?;
                error
            }
        };
        let length = master.time() - start;
        self.count.made += 1;
        if master.time() < self.stop {
            let [shortest, longest] = self.count.lengths.unwrap_or([length; 2]);
            self.count.lengths = Some([shortest.min(length), longest.max(length)]);
        }
        master.last_step = LastStep { length, error };
        Ok(())
    }

    fn step_to(&mut self, master: &mut Master, end: f64) -> Result<()> {
        for (before, residual) in self.before.iter_mut().zip(master.residuals()) {
            *before = [residual.energy, residual.turnover];
        }
        self.count.computed += 1;
        master.step_to(end)
    }

    /// Steps to these times; returns where a component stopped early, if one did.
    fn attempt(&mut self, master: &mut Master, times: &[f64]) -> Result<Option<Stopped>> {
        for time in times {
            if let Err(error) = self.step_to(master, *time) {
                return match error.downcast_ref::<Stopped>() {
                    Some(stopped) => Ok(Some(stopped.clone())),
                    None => Err(error),
                };
            }
        }
        Ok(None)
    }

    /// The next multiple of the step, or the stop time, s.
    fn end_on_grid(&self, master: &Master) -> f64 {
        let (start, h) = (master.stepping().start, self.controller.state.next);
        let passed = ((master.time() - start) / h + 1e-6).floor();
        let end = (start + (passed + 1.0) * h).min(self.stop);
        match self.stop - end < 1e-6 * h {
            true => self.stop,
            false => end,
        }
    }

    /// Repeats a step until no component stops within it and its error is small enough, or it is
    /// the shortest; returns the error.
    fn repeated(&mut self, master: &mut Master) -> Result<f64> {
        let t = master.time();
        let saved = master.save()?;
        let doubles = matches!(self.control, StepControl::Doubling { .. });
        let on_grid = matches!(self.control, StepControl::Fixed | StepControl::Repeated);
        let mut end = match on_grid {
            true => self.end_on_grid(master),
            false => self.controller.end(t, self.stop),
        };
        let (first, mut last_stop) = (end - t, None);
        for _ in 0..REPEATS {
            let mut stopped = self.attempt(master, &[end])?;
            if stopped.is_none() && doubles {
                self.whole.clone_from(&master.exchange().values);
                master.restore(&saved)?;
                stopped = self.attempt(master, &[t + 0.5 * (end - t), end])?;
            }
            if let Some(stopped) = stopped {
                master.restore(&saved)?;
                end = shorter(t, end, &stopped);
                last_stop = Some(stopped);
                if end - t < LEAST_PART * first {
                    break;
                }
                continue;
            }
            if on_grid {
                return Ok(0.0);
            }
            let (error, most) = (self.error(master), if doubles { 1.0 } else { TOO_LARGE });
            self.controller.follow(end - t, error)?;
            if error <= most || self.controller.is_shortest(end - t) {
                return Ok(error);
            }
            master.restore(&saved)?;
            // Shorter in any case.
            end = (t + 0.9 * (end - t)).min(t + self.controller.state.next);
        }
        let at = At::Time(t);
        let Some(Stopped { name, time }) = last_stop else {
            bail!("{at} the error of the communication step is too large, however short it is")
        };
        let to = time.map_or(String::new(), |time| {
            format!(", the last time at {} s", short(time))
        });
        bail!("{at} `{name}` stops within the communication step{to}, however short it is")
    }

    /// Error of the last step relative to the allowed one: of the energy residuals; or of outputs,
    /// which is the largest difference between a whole step and two halves relative to nominal and
    /// present value.
    fn error(&self, master: &Master) -> f64 {
        match self.control {
            StepControl::Fixed | StepControl::Repeated => 0.0,
            StepControl::Energy {
                tolerance, scale, ..
            } => {
                let bonds = master.residuals().iter().zip(&self.before);
                let squares = bonds.map(|(residual, [energy, turnover])| {
                    let allowed = tolerance * (scale + (residual.turnover - turnover).abs());
                    ((residual.energy - energy) / allowed).powi(2)
                });
                (squares.sum::<f64>() / self.before.len() as f64).sqrt()
            }
            StepControl::Doubling { tolerance, .. } => {
                let values = master.exchange().values.iter().zip(&self.whole);
                let relative = values.zip(&self.nominal);
                let relative = relative.map(|((y, whole), n)| (y - whole).abs() / (n + y.abs()));
                relative.fold(0.0, f64::max) / tolerance
            }
        }
    }
}

impl StepControl {
    /// Whether steps may be repeated, so that all components must save their states.
    pub fn repeats(&self) -> bool {
        matches!(
            self,
            Self::Repeated | Self::Energy { repeats: true, .. } | Self::Doubling { .. }
        )
    }
}

/// New end of the step from `t` to `end` after a component stopped within it, s: where it stopped,
/// or half-way if it does not report that.
fn shorter(t: f64, end: f64, stopped: &Stopped) -> f64 {
    let least = 1e-6 * (end - t);
    let is_within = |time: &f64| (t + least..end - least).contains(time);
    let reported = stopped.time.filter(is_within);
    reported.unwrap_or(t + 0.5 * (end - t))
}
