//! Communication steps whose lengths are chosen on the way, and steps that are repeated.

use anyhow::{Result, bail, ensure};
use fmi_description::{Access, Variability, Variable};

use super::control::{Control, Limits, Progress, Regulator};
use crate::instance::Stopped;
use crate::master::{LastStep, Master};
use crate::structure::system::System;

/// Times that a step is repeated before that is a failure.
const REPEATS: usize = 100;

/// Error from which on a step that is chosen by energy is repeated, where that is asked for: the
/// controller holds errors near 1.
const TOO_LARGE: f64 = 2.0;

/// Steps of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepCount {
    /// Steps that the run is made of.
    pub made: u64,
    /// Steps that every component made, with those that were repeated or that served to compare.
    pub computed: u64,
    /// Shortest and longest of those that the run is made of, but for the last, s.
    pub lengths: Option<[f64; 2]>,
}

/// Communication steps whose lengths are chosen.
pub struct ChosenSteps {
    control: Control,
    regulator: Regulator,
    stop: f64,
    count: StepCount,
    /// Energy residual and turnover of each bond before the step, J.
    before: Vec<[f64; 2]>,
    /// Outputs after a whole step.
    whole: Vec<f64>,
    /// Nominal value of each connected output that is compared; infinite for the others.
    nominal: Vec<f64>,
}

impl ChosenSteps {
    /// Of `master`, which runs `system`, to `stop`, s.
    ///
    /// # Errors
    /// A stop time that is not after the start; no bond by which lengths could be chosen; limits or
    /// a tolerance that make no sense; a delay, which counts steps of one length; a component that
    /// cannot save its state where steps are repeated.
    pub fn new(system: &System, master: &Master, stop: f64, control: &Control) -> Result<Self> {
        let (step, start) = (master.stepping().step, master.time());
        ensure!(
            stop > start && stop.is_finite(),
            "from {start} s to {stop} s: no run"
        );
        if let Some(delay) = master.exchange().faults.as_ref().and_then(|f| f.delay()) {
            bail!("a delay of {delay} s needs communication steps of one length");
        }
        let (tolerance, limits) = match *control {
            Control::Fixed | Control::Repeated => {
                let length = [step; 2];
                (
                    1.0,
                    Limits {
                        length,
                        ..Limits::default()
                    },
                )
            }
            Control::Energy {
                tolerance, limits, ..
            } => (tolerance, limits),
            Control::Doubling { tolerance, limits } => (tolerance, first_order(limits)),
        };
        ensure!(
            tolerance > 0.0 && tolerance.is_finite(),
            "tolerance {tolerance} of the communication steps must be greater than 0"
        );
        let remembers = matches!(control, Control::Energy { .. });
        let mut first = step;
        if let Control::Energy { scale, .. } = *control {
            // A step that was too long to begin with would not be noticed before it is over.
            first = limits.length[0];
            ensure!(
                scale > 0.0 && scale.is_finite(),
                "energy {scale} J from which on the tolerance counts must be greater than 0"
            );
            ensure!(
                !master.residuals().is_empty(),
                "the system has no power bond by whose energy the step could be chosen"
            );
        }
        if control.repeats() {
            // Refused now rather than in the middle of the run.
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
            regulator: Regulator::new(limits, first, remembers)?,
            control: *control,
            stop,
            count: StepCount::default(),
            before: vec![[0.0; 2]; master.residuals().len()],
            whole: Vec::new(),
            nominal: nominal.collect(),
        })
    }

    /// s.
    pub fn stop(&self) -> f64 {
        self.stop
    }

    /// How many steps were made.
    pub fn made(&self) -> StepCount {
        self.count
    }

    /// Numbers of steps that are made, and of all, were the rest as long as the next one.
    pub fn so_far(&self, master: &Master) -> (u64, u64) {
        let rest = ((self.stop - master.time()) / self.regulator.next).ceil();
        (self.count.made, self.count.made + rest as u64)
    }

    pub(super) fn progress(&self) -> Progress {
        Progress {
            made: self.count.made,
            next: self.regulator.next,
            error: self.regulator.before,
            length: self.regulator.length,
        }
    }

    pub(super) fn go_on(&mut self, progress: Progress) {
        let regulator = &mut self.regulator;
        (regulator.next, regulator.before) = (progress.next, progress.error);
        regulator.length = progress.length;
    }

    /// Make a step.
    pub fn make(&mut self, master: &mut Master) -> Result<()> {
        let start = master.time();
        let error = match self.control {
            Control::Fixed | Control::Repeated => {
                self.on_grid(master)?;
                0.0
            }
            Control::Energy { repeats: false, .. } => {
                let end = self.regulator.end(start, self.stop);
                self.step_to(master, end)?;
                let error = self.energy_error(master);
                self.regulator.follow(end - start, error)?;
                error
            }
            Control::Energy { .. } | Control::Doubling { .. } => self.repeated(master)?,
        };
        let length = master.time() - start;
        self.count.made += 1;
        if master.time() < self.stop {
            let [shortest, longest] = self.count.lengths.unwrap_or([length; 2]);
            self.count.lengths = Some([shortest.min(length), longest.max(length)]);
        }
        master.note_step(LastStep { length, error });
        Ok(())
    }

    fn step_to(&mut self, master: &mut Master, end: f64) -> Result<()> {
        for (before, residual) in self.before.iter_mut().zip(master.residuals()) {
            *before = [residual.energy, residual.turnover];
        }
        self.count.computed += 1;
        master.step_to(end)
    }

    /// Step to these times; where a component stopped before that, if one did.
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

    /// To the next multiple of the step, or to where a component stops.
    fn on_grid(&mut self, master: &mut Master) -> Result<()> {
        let (start, t, h) = (master.stepping().start, master.time(), self.regulator.next);
        let passed = ((t - start) / h + 1e-6).floor();
        let mut end = (start + (passed + 1.0) * h).min(self.stop);
        if self.stop - end < 1e-6 * h {
            end = self.stop;
        }
        let saved = master.save()?;
        for _ in 0..REPEATS {
            let Some(stopped) = self.attempt(master, &[end])? else {
                return Ok(());
            };
            master.restore(&saved)?;
            end = shorter(t, end, &stopped);
        }
        bail!("at t = {t} s a component stops however short the step is, {REPEATS} times")
    }

    /// A step whose error is small enough, or the shortest one.
    fn repeated(&mut self, master: &mut Master) -> Result<f64> {
        let t = master.time();
        let saved = master.save()?;
        let doubles = matches!(self.control, Control::Doubling { .. });
        let mut end = self.regulator.end(t, self.stop);
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
                continue;
            }
            let (error, most) = match doubles {
                true => (self.difference(master), 1.0),
                false => (self.energy_error(master), TOO_LARGE),
            };
            self.regulator.follow(end - t, error)?;
            if error <= most || self.regulator.is_shortest(end - t) {
                return Ok(error);
            }
            master.restore(&saved)?;
            // No longer one, whatever the step before was like.
            end = (t + 0.9 * (end - t)).min(t + self.regulator.next);
        }
        bail!("at t = {t} s no communication step succeeds, however short, {REPEATS} times")
    }

    /// Energy residuals of the last step beside what is allowed.
    fn energy_error(&self, master: &Master) -> f64 {
        let Control::Energy {
            tolerance, scale, ..
        } = self.control
        else {
            return 0.0;
        };
        let bonds = master.residuals().iter().zip(&self.before);
        let squares = bonds.map(|(residual, [energy, turnover])| {
            let allowed = tolerance * (scale + (residual.turnover - turnover).abs());
            ((residual.energy - energy) / allowed).powi(2)
        });
        (squares.sum::<f64>() / self.before.len() as f64).sqrt()
    }

    /// Largest difference of outputs between a whole step and two halves, beside what is allowed.
    fn difference(&self, master: &Master) -> f64 {
        let Control::Doubling { tolerance, .. } = self.control else {
            return 0.0;
        };
        let values = master.exchange().values.iter().zip(&self.whole);
        let mut largest = 0.0_f64;
        for ((value, whole), nominal) in values.zip(&self.nominal) {
            largest = largest.max((value - whole).abs() / (nominal + value.abs()));
        }
        largest / tolerance
    }
}

impl Control {
    /// Whether steps may be repeated, for which all components must save their states.
    pub fn repeats(&self) -> bool {
        matches!(
            self,
            Self::Repeated | Self::Energy { repeats: true, .. } | Self::Doubling { .. }
        )
    }
}

/// Where the step from `t` to `end` is to end now that a component stopped, s: there, or half-way
/// where it does not say where.
fn shorter(t: f64, end: f64, stopped: &Stopped) -> f64 {
    let least = 1e-6 * (end - t);
    let is_within = |time: &f64| (t + least..end - least).contains(time);
    let told = stopped.time.filter(is_within);
    told.unwrap_or(t + 0.5 * (end - t))
}

/// The error of a step grows with the square of its length.
fn first_order(limits: Limits) -> Limits {
    Limits {
        proportional: 0.0,
        integral: 0.5,
        ..limits
    }
}
