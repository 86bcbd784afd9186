//! [`Integrator`]: integrates over any number of communication steps, for an importer whose models
//! leave that to it. Internal steps may end after a communication point, whose states are then
//! interpolated: where no input changes, short communication steps cost no evaluations. It begins
//! with the explicit method, and continues with the stiff one where that would take fewer steps.

use std::mem::swap;

use super::adaptive::Control;
use super::algorithm::{Algorithm, Step};
use super::dormand_prince::DormandPrince;
use super::rosenbrock::Rosenbrock;
use super::runge_kutta::RungeKutta;
use super::sparsity_pattern::SparsityPattern;
use super::system::System;
use super::{Counts, Failure, Workspace};

/// Product of step and rate above which the explicit method is limited by its stability.
const STIFF: f64 = 3.25;
/// Steps above this product that make a model stiff, and steps in a row below it that clear them.
const STIFF_STEPS: [u32; 2] = [15, 6];
/// Numbers of the saved state before its vectors.
const SCALARS: usize = 14;

/// By which method an [`Integrator`] makes its internal steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Choice {
    /// The explicit one, then the stiff one where that takes fewer steps.
    #[default]
    Automatic,
    /// The explicit one.
    Explicit,
    /// The stiff one, if there is a pattern of the Jacobian.
    Stiff,
    /// Runge and Kutta's of order 4 with equal internal steps of at most this length, s.
    Fixed(f64),
}

/// Why [`Integrator::advance`] has stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// At the time that was asked for.
    Wanted,
    /// At the end of an internal step.
    StepEnd,
    /// Just after an event: call [`Integrator::restart`] once it is handled.
    Event,
}

/// A solver with a tolerance that remembers its internal step between communication steps.
pub struct Integrator {
    choice: Choice,
    explicit: DormandPrince,
    /// In use once the model is found stiff.
    stiff: Option<Box<Rosenbrock>>,
    fixed: Option<RungeKutta>,
    pattern: Option<SparsityPattern>,
    workspace: Workspace,
    control: Control,
    /// Present place, and how far the last internal step is valid, s from `step.t`.
    at: f64,
    reach: f64,
    /// Where in the internal step an event is, from 0 to 1.
    event: Option<f64>,
    /// Steps limited by stability, and since then steps that are not.
    stiff_steps: [u32; 2],
}

impl Integrator {
    /// For states with these nominal values (magnitudes, > 0), this number of event indicators, and
    /// the pattern of the Jacobian, without which the stiff method is not used. No internal step is
    /// longer than `longest`, s, which is finite.
    #[must_use]
    pub fn new(
        choice: Choice,
        nominal: Vec<f64>,
        indicators: usize,
        pattern: Option<SparsityPattern>,
        longest: f64,
    ) -> Self {
        let is_fixed = matches!(choice, Choice::Fixed(_));
        Self {
            choice,
            explicit: DormandPrince::new(nominal.len()),
            stiff: None,
            fixed: is_fixed.then(|| RungeKutta::new(nominal.len())),
            pattern,
            workspace: Workspace::new(nominal, indicators, longest, true),
            control: Control::new(0.0),
            at: 0.0,
            reach: 0.0,
            event: None,
            stiff_steps: [0; 2],
        }
    }

    /// Sets the allowed error of an internal step, as [`Solver::set_tolerance`](super::Solver).
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.workspace.tolerance = tolerance;
    }

    /// Sets the length of the longest internal step, s.
    pub fn set_longest(&mut self, longest: f64) {
        self.workspace.longest = longest;
    }

    /// The nominal values, which may change at events.
    pub fn nominal_mut(&mut self) -> &mut [f64] {
        &mut self.workspace.step.nominal
    }

    /// The counts so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.workspace.counts
    }

    /// Whether the stiff method is in use.
    #[must_use]
    pub fn is_stiff(&self) -> bool {
        let is_found = match self.choice {
            Choice::Automatic => self.stiff_steps[0] >= STIFF_STEPS[0],
            choice => choice == Choice::Stiff,
        };
        is_found && self.pattern.is_some()
    }

    /// Time of the last restart, s.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.workspace.step.t
    }

    /// Present time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.workspace.step.t + self.at
    }

    /// Continues from `t`, s, with the states `x`: at the start, after an event, or with other
    /// inputs. With `is_other` the solution may change completely there, and the next internal step
    /// is a short one.
    ///
    /// # Errors
    /// The indicators cannot be evaluated.
    pub fn restart<S: System>(
        &mut self,
        system: &mut S,
        t: f64,
        x: &[f64],
        is_other: bool,
    ) -> Result<(), S::Error> {
        let step = &mut self.workspace.step;
        (step.t, step.s, step.dt) = (t, 0.0, 0.0);
        step.x.copy_from_slice(x);
        let indicators = &mut self.workspace.indicators;
        // An importer cannot know what the event has done: each change of a sign is another one.
        indicators.fired.fill(false);
        (self.at, self.reach, self.event) = (0.0, 0.0, None);
        if is_other {
            self.control = Control::new(0.0);
        }
        match indicators.is_empty() {
            true => Ok(()),
            false => system.indicators(0.0, x, &mut indicators.values[0]),
        }
    }

    /// Advances to `until` at most, in s from the last restart, and writes the states there to `x`.
    /// A new internal step may go to `limit` at most, which is not before `until`.
    ///
    /// # Errors
    /// See [`Failure`]; the place stays as it was.
    pub fn advance<S: System>(
        &mut self,
        system: &mut S,
        [until, limit]: [f64; 2],
        x: &mut [f64],
    ) -> Result<Stop, Failure<S::Error>> {
        if self.at == self.reach && self.event.is_none() && self.at < until {
            self.complete();
            let done = self.internal_step(system, [until, limit]);
            done.inspect_err(|_| self.workspace.step.dt = 0.0)?;
        }
        let (stop, at) = match self.event {
            _ if until < self.reach => (Stop::Wanted, until),
            Some(_) => (Stop::Event, self.reach),
            None if until == self.reach => (Stop::Wanted, until),
            None => (Stop::StepEnd, self.reach),
        };
        self.at = at;
        let step = &self.workspace.step;
        match self.event {
            Some(theta) if stop == Stop::Event => {
                x.copy_from_slice(self.workspace.step.interpolate(theta));
            }
            _ if at == self.reach && step.dt > 0.0 => x.copy_from_slice(&step.end),
            _ => x.copy_from_slice(self.states_at(at)),
        }
        Ok(stop)
    }

    /// The states within the last internal step, s from the last restart.
    pub fn states_at(&mut self, s: f64) -> &[f64] {
        let step = &mut self.workspace.step;
        match step.dt > 0.0 {
            true => step.interpolate((s - step.s) / step.dt),
            false => &step.x,
        }
    }

    /// The end of the last internal step is the start of the next one.
    fn complete(&mut self) {
        let Workspace {
            step, indicators, ..
        } = &mut self.workspace;
        if step.dt > 0.0 {
            swap(&mut step.x, &mut step.end);
            (step.s, step.dt) = (self.reach, 0.0);
            indicators.pass();
        }
    }

    fn internal_step<S: System>(
        &mut self,
        system: &mut S,
        [until, limit]: [f64; 2],
    ) -> Result<(), Failure<S::Error>> {
        let is_stiff = self.is_stiff();
        let Self {
            explicit,
            workspace,
            control,
            ..
        } = self;
        let s = workspace.step.s;
        let rest = limit - s;
        let lengths = [rest, rest.min(workspace.longest)];
        if workspace.step.x.is_empty() {
            workspace.step.dt = (until - s).min(workspace.longest);
        } else if let (Choice::Fixed(longest), Some(method)) = (self.choice, &mut self.fixed) {
            let rest = until - s;
            workspace.step.dt = rest / (rest / longest).ceil();
            method.begin(system, &workspace.step)?;
            method.step(system, &mut workspace.step)?;
            method.dense_output(system, &mut workspace.step)?;
        } else if let (true, Some(pattern)) = (is_stiff, &self.pattern) {
            let make = || Box::new(Rosenbrock::new(pattern.clone()));
            let method = &mut **self.stiff.get_or_insert_with(make);
            workspace.controlled_step(method, system, lengths, control)?;
            method.dense_output(system, &mut workspace.step)?;
        } else {
            workspace.controlled_step(explicit, system, lengths, control)?;
            explicit.dense_output(system, &mut workspace.step)?;
            let dt = workspace.step.dt;
            let [limited, others] = &mut self.stiff_steps;
            // A step that may not be longer is no sign of stiffness.
            (*limited, *others) = match dt < rest && explicit.stiffness(dt) > STIFF {
                true => ((*limited + 1).min(STIFF_STEPS[0]), 0),
                false if *others + 1 < STIFF_STEPS[1] => (*limited, *others + 1),
                false => (0, 0),
            };
        }
        let dt = workspace.step.dt;
        workspace.counts.steps += 1;
        self.event = workspace.event_in_step(system)?;
        // Where it ends exactly, if it goes as far as it may.
        let mut ends = [until, limit].into_iter();
        let end = ends.find(|end| end - s == dt).unwrap_or(s + dt);
        self.reach = self.event.map_or(end, |theta| s + theta * dt);
        Ok(())
    }

    /// The state, as numbers: afterwards [`Integrator::set_state`] continues from here, bit for bit.
    #[must_use]
    pub fn state(&self) -> Vec<f64> {
        let Workspace { step, counts, .. } = &self.workspace;
        let mut numbers = vec![
            step.t,
            step.s,
            step.dt,
            self.at,
            self.reach,
            self.event.unwrap_or(f64::NAN),
            self.control.dt,
            self.control.most,
            self.workspace.longest,
            f64::from(self.stiff_steps[0]),
            f64::from(self.stiff_steps[1]),
            counts.steps as f64,
            counts.rejected as f64,
            counts.jacobians as f64,
        ];
        self.vectors().for_each(|vector| numbers.extend(vector));
        numbers
    }

    /// Restores a state; returns false, and does nothing, if it is that of another model.
    pub fn set_state(&mut self, numbers: &[f64]) -> bool {
        let all: usize = self.vectors().map(Vec::len).sum();
        let Some((scalars, mut rest)) = numbers.split_first_chunk::<SCALARS>() else {
            return false;
        };
        if rest.len() != all {
            return false;
        }
        let step = &mut self.workspace.step;
        let event;
        let [limited, others, steps, rejected, jacobians];
        [
            step.t,
            step.s,
            step.dt,
            self.at,
            self.reach,
            event,
            self.control.dt,
            self.control.most,
            self.workspace.longest,
            limited,
            others,
            steps,
            rejected,
            jacobians,
        ] = *scalars;
        self.event = Some(event).filter(|theta| !theta.is_nan());
        self.stiff_steps = [limited, others].map(|count| count as u32);
        let [steps, rejected, jacobians] = [steps, rejected, jacobians].map(|count| count as u64);
        self.workspace.counts = Counts {
            steps,
            rejected,
            jacobians,
        };
        for vector in self.vectors_mut() {
            let (own, others) = rest.split_at(vector.len());
            vector.copy_from_slice(own);
            rest = others;
        }
        true
    }

    /// What the next internal step depends on.
    fn vectors(&self) -> impl Iterator<Item = &Vec<f64>> {
        let Step {
            nominal,
            x,
            end,
            dense,
            ..
        } = &self.workspace.step;
        let [start, after, ..] = &self.workspace.indicators.values;
        [nominal, x, end, start, after, &self.explicit.0[6]]
            .into_iter()
            .chain(dense)
    }

    fn vectors_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let Step {
            nominal,
            x,
            end,
            dense,
            ..
        } = &mut self.workspace.step;
        let [start, after, ..] = &mut self.workspace.indicators.values;
        [nominal, x, end, start, after, &mut self.explicit.0[6]]
            .into_iter()
            .chain(dense)
    }
}

impl Workspace {
    /// Where in the internal step the first event is, from 0 to 1.
    fn event_in_step<S: System>(&mut self, system: &mut S) -> Result<Option<f64>, S::Error> {
        let (step, indicators) = (&mut self.step, &mut self.indicators);
        if indicators.is_empty() {
            return Ok(None);
        }
        let Some(within) = indicators.find(system, step)? else {
            return Ok(None);
        };
        indicators.locate(system, step, within).map(Some)
    }
}
