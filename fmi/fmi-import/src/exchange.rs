//! [`ExchangeInstance`]: an instance for Model Exchange behind [`FmiInstance`], made by
//! `instantiate`: it integrates the states over each communication step and handles events, so that
//! a master steps it like an instance for Co-Simulation.
//!
//! Between steps the FMU is in Continuous-Time Mode at the communication point, or in Event Mode
//! after a value was set that may change at events only.

mod crowding;
mod equations;
mod integrals;
mod plan;
mod ramp;
mod start;
mod work;

use std::any::Any;
use std::cell::RefCell;
use std::ffi::CString;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::{Context, Error, Result, bail};
use fmu_solver::{Failure, Integrator, Stop, TOLERANCE};

use crate::answer::{Answer, Ended};
use crate::batch::Batch;
use crate::digits::short;
use crate::fmi_instance::{Call, FmiInstance, Integration, MAX_PASSES};
use crate::raw::{ContinuousValues, RawInstance};
use crate::value::Value;
use equations::{Equations, Fault, check};
pub use plan::{ExchangePlan, as_component};
use ramp::Ramp;
use work::{SavedWork, Tracked, Work};

/// Most internal steps and events within one communication step.
const MAX_STEPS: u64 = 10_000_000;
/// Part of the tolerance for internal steps: errors add up, and states between their ends, where
/// communication points are, are less exact.
const SAFETY: f64 = 0.1;
/// Times that differ by less than this part are the same.
const SAME: f64 = 1e-12;

/// An instance for Model Exchange; freed when dropped.
pub struct ExchangeInstance {
    raw: Rc<RawInstance>,
    inner: Box<dyn FmiInstance>,
    plan: Arc<ExchangePlan>,
    work: RefCell<Work>,
}

struct Saved {
    inner: Box<dyn Any>,
    tracked: SavedWork,
}

impl ExchangeInstance {
    /// `inner` must have been made of `raw`, which has just been instantiated.
    pub fn new(
        raw: Rc<RawInstance>,
        inner: Box<dyn FmiInstance>,
        plan: &Arc<ExchangePlan>,
    ) -> Self {
        Self {
            work: RefCell::new(Work::new(plan)),
            raw,
            inner,
            plan: plan.clone(),
        }
    }

    fn equations<'a>(&'a self, work: &'a mut Work) -> (&'a mut Integrator, Equations<'a>) {
        let Work {
            integrator,
            ramps,
            tracked,
            ..
        } = work;
        let equations = Equations {
            raw: &self.raw,
            inner: &*self.inner,
            plan: &self.plan,
            t: integrator.start(),
            ramps,
            sides: &tracked.sides,
            evaluations: &mut tracked.evaluations,
        };
        (integrator, equations)
    }

    /// A communication step from `t` by `h`, both s.
    fn step(&self, t: f64, h: f64) -> Result<()> {
        let work = &mut *self.work.borrow_mut();
        if work.tracked.is_in_event_mode {
            self.settle(work)?;
        }
        let end = t + h;
        let close = SAME * end.abs().max(h);
        if !work.tracked.is_started {
            work.integrator
                .set_longest(self.plan.longest.unwrap_or(100.0 * h));
        }
        // Internal steps go on beyond the communication step if no input seems to change there.
        let is_free =
            !work.tracked.is_changed && (work.tracked.is_started || !self.plan.has_inputs);
        if work.tracked.is_changed {
            match self.inputs_make_event(work)? {
                true => self.event(work)?,
                false => self.restart(work, false)?,
            }
        }
        (work.tracked.is_changed, work.tracked.is_started) = (false, true);
        work.integrals.clear();
        for _ in 0..MAX_STEPS {
            let Tracked { time, next, .. } = work.tracked;
            if end - time <= close {
                work.integrals.write_means(h, &mut work.tracked.means);
                return Ok(());
            }
            let until = if next <= end + close { next } else { end };
            let limit = if is_free { next } else { until };
            self.internal_step(work, [until, limit])?;
        }
        bail!(
            "more than {MAX_STEPS} internal steps until t = {} s: a communication step must have fewer",
            short(work.tracked.time)
        )
    }

    /// Advances to `until` at most, s; a new internal step may go to `limit`. Handles what happens
    /// there.
    fn internal_step(&self, work: &mut Work, [until, limit]: [f64; 2]) -> Result<()> {
        let (start, from) = (work.integrator.start(), work.tracked.time);
        let mut x = std::mem::take(&mut work.tracked.x);
        let mut integrals = std::mem::take(&mut work.integrals);
        let (integrator, mut equations) = self.equations(work);
        let advanced = integrator.advance(&mut equations, [until - start, limit - start], &mut x);
        let now = match advanced {
            Ok(Stop::Wanted) => until,
            _ => integrator.time(),
        };
        let set = advanced.map(|stop| {
            let added = integrals.add(integrator, &mut equations, [from, now]);
            (stop, added.and_then(|()| equations.set(now, &x)))
        });
        (work.tracked.x, work.integrals) = (x, integrals);
        let (stop, set) = set.map_err(|failure| self.explain(failure, start, work.tolerance))?;
        set?;
        work.tracked.time = now;
        if work.integrator.is_stiff() {
            work.tracked.stiff_since.get_or_insert(now);
        }
        let mut told = [false; 2];
        if self.plan.completes_steps {
            let status = self.raw.completed_integrator_step(&mut told);
            check(&self.raw, status, "fmi2CompletedIntegratorStep")?;
        }
        let [wants_event, ends] = told;
        if ends {
            let call = self.raw.functions().name("fmi2CompletedIntegratorStep");
            bail!(Ended { call, time: now });
        }
        match stop == Stop::Event || wants_event || now == work.tracked.next {
            true => self.event(work),
            false => Ok(()),
        }
    }

    /// Handles an event at the present time.
    fn event(&self, work: &mut Work) -> Result<()> {
        let tracked = &mut work.tracked;
        tracked.events += 1;
        tracked.crowding.add(tracked.time)?;
        self.enter_events(work)?;
        self.settle(work)
    }

    fn enter_events(&self, work: &mut Work) -> Result<()> {
        if !work.tracked.is_in_event_mode {
            work.tracked.is_in_event_mode = true;
            self.inner.call(Call::SetTime(work.tracked.time))?;
            self.inner.call(Call::EnterEvents)?;
        }
        Ok(())
    }

    /// Updates discrete states until no further update is needed, then leaves Event Mode.
    fn settle(&self, work: &mut Work) -> Result<()> {
        for _ in 0..MAX_PASSES {
            if self.inner.call(Call::UpdateEvents)? == 0.0 {
                return self.leave_events(work);
            }
        }
        bail!(
            "discrete states still change after {MAX_PASSES} passes of Event Mode at t = {} s",
            short(work.tracked.time)
        )
    }

    /// To Continuous-Time Mode, with the states that the event has set.
    fn leave_events(&self, work: &mut Work) -> Result<()> {
        self.inner.call(Call::LeaveEvents)?;
        let next = self.inner.call(Call::NextTimeEvent)?;
        let (mut x, mut z) = (
            std::mem::take(&mut work.tracked.x),
            std::mem::take(&mut work.z),
        );
        let (integrator, equations) = self.equations(work);
        let read = || -> Result<(), Answer> {
            equations.get(ContinuousValues::States, &mut x)?;
            equations.get(ContinuousValues::Indicators, &mut z)?;
            equations.get(ContinuousValues::Nominals, integrator.nominal_mut())
        };
        let read = { read }();
        let unfit = start::unfit(&self.plan, &x, &z, integrator.nominal_mut());
        let tracked = &mut work.tracked;
        tracked.sides.set(&z);
        tracked.next = if next > tracked.time {
            next
        } else {
            f64::INFINITY
        };
        (tracked.is_in_event_mode, tracked.x, work.z) = (false, x, z);
        read?;
        let (time, close) = (tracked.time, SAME * tracked.time.abs().max(1.0));
        if let Some(unfit) = unfit {
            bail!("{unfit} after the event at t = {} s", short(time));
        }
        if next < time - close {
            let [next, time] = [next, time].map(short);
            bail!("its next time event, at {next} s, is in the past at t = {time} s");
        }
        self.restart(work, true)
    }

    /// The integrator continues from the present states; with `is_other` they were set anew.
    fn restart(&self, work: &mut Work, is_other: bool) -> Result<()> {
        let (time, tolerance) = (work.tracked.time, work.tolerance);
        let x = std::mem::take(&mut work.tracked.x);
        let (integrator, mut equations) = self.equations(work);
        equations.t = time;
        let done = integrator.restart(&mut equations, time, &x, is_other);
        work.tracked.x = x;
        done.map_err(|fault| self.explain(Failure::System(fault), time, tolerance))
    }

    /// Whether the inputs that were set are an event.
    fn inputs_make_event(&self, work: &mut Work) -> Result<bool> {
        if work.z.is_empty() {
            return Ok(false);
        }
        let mut z = std::mem::take(&mut work.z);
        let (_, equations) = self.equations(work);
        let read = equations.get(ContinuousValues::Indicators, &mut z);
        work.z = z;
        read?;
        Ok(work.tracked.sides.has_event(&work.z))
    }

    /// Notes values that are about to be set, as bits and None for texts; enters Event Mode if some
    /// may be set there only. Returns false if they need not be set, since none has changed.
    fn note(&self, batch: &Batch, value: impl Fn(usize) -> Option<u64>) -> Result<bool> {
        let work = &mut *self.work.borrow_mut();
        let (mut is_changed, mut is_continuous) = (false, true);
        if work.tracked.is_initialized {
            let now = work.tracked.time;
            work.ramps.iter_mut().for_each(|ramp| ramp.move_to(now));
        }
        for (k, variable) in batch.variables.iter().enumerate() {
            let (given, new) = (&mut work.tracked.given[*variable], value(k));
            is_changed |= *given != new || new.is_none();
            *given = new;
            is_continuous &= self.plan.is_continuous[*variable];
            let new = f64::from_bits(new.unwrap_or_default());
            for ramp in &mut work.ramps {
                is_changed |= ramp.take(*variable, new);
            }
        }
        work.tracked.is_changed |= is_changed;
        if is_changed && !is_continuous && work.tracked.is_initialized {
            self.enter_events(work)?;
        }
        Ok(is_changed || is_continuous)
    }

    #[cold]
    fn explain(&self, failure: Failure<Fault>, start: f64, tolerance: f64) -> Error {
        match failure {
            Failure::System(Fault::Answer(answer)) => answer.into(),
            Failure::System(Fault::Indicator(k, t)) => {
                anyhow::anyhow!("event indicator {} is NaN at t = {} s", k + 1, short(t))
            }
            Failure::System(Fault::NotFinite(state, value, t)) => {
                let name = &self.plan.names[state];
                anyhow::anyhow!(
                    "the derivative of `{name}` is {value} at t = {} s, and shorter steps do not help",
                    short(t)
                )
            }
            Failure::TooShort(s, dt) => anyhow::anyhow!(
                "the error of an internal step of {} s at t = {} s is above the tolerance {tolerance} (--tolerance)",
                short(dt),
                short(start + s)
            ),
            Failure::TooManySteps(..) | Failure::NotFinite(..) => {
                anyhow::anyhow!(
                    "the states cannot be integrated from t = {} s",
                    short(start)
                )
            }
        }
    }
}

impl FmiInstance for ExchangeInstance {
    fn log_only(&self, categories: &[CString]) -> Result<()> {
        self.inner.log_only(categories)
    }

    fn get_values(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        self.inner.get_values(batch, values)
    }

    fn set_values(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        let is_new = self.note(batch, |k| match &values[k] {
            Value::Text(_) | Value::Bytes(_) => None,
            number => Some(number.bits()),
        })?;
        match is_new {
            true => self.inner.set_values(batch, values),
            false => Ok(()),
        }
    }

    fn call(&self, call: Call) -> Result<f64> {
        let inner = &self.inner;
        match call {
            Call::Step(t, h) => return self.step(t, h).map(|()| 0.0),
            Call::Time => return Ok(self.work.borrow().tracked.time),
            Call::StopEarly(_) => return Ok(0.0), // steps do not end early
            Call::InEvents => {
                return Ok(f64::from(u8::from(
                    self.work.borrow().tracked.is_in_event_mode,
                )));
            }
            Call::SetUp(mut experiment) => {
                let work = &mut *self.work.borrow_mut();
                work.tolerance = match experiment.has_tolerance {
                    true => experiment.tolerance,
                    false => TOLERANCE,
                };
                work.integrator.set_tolerance(SAFETY * work.tolerance);
                // Internal steps may go beyond it.
                experiment.has_stop = false;
                return inner.call(Call::SetUp(experiment));
            }
            Call::EnterInitialization(start) => self.work.borrow_mut().tracked.time = start,
            Call::Tick(..) => {
                let work = &mut *self.work.borrow_mut();
                work.tracked.events += 1;
                self.enter_events(work)?;
            }
            Call::ExitInitialization => {
                inner.call(call)?;
                let work = &mut *self.work.borrow_mut();
                (work.tracked.is_in_event_mode, work.tracked.is_initialized) = (true, true);
                let now = work.tracked.time;
                work.ramps.iter_mut().for_each(|ramp| ramp.start = now);
                start::check_numbers(&self.raw, &self.plan)?;
                self.settle(work)?;
                start::check_vectors(&self.raw, &self.plan)?;
                work.tracked.is_changed = false;
                return Ok(0.0);
            }
            Call::EnterEvents => return Ok(0.0), // where it is needed
            Call::UpdateEvents => {
                let work = &mut *self.work.borrow_mut();
                if work.tracked.is_changed && self.inputs_make_event(work)? {
                    self.enter_events(work)?;
                }
                return match work.tracked.is_in_event_mode {
                    true => inner.call(call),
                    false => Ok(0.0),
                };
            }
            Call::LeaveEvents | Call::Settle => {
                let work = &mut *self.work.borrow_mut();
                if work.tracked.is_in_event_mode {
                    match call {
                        Call::Settle => self.settle(work)?,
                        _ => self.leave_events(work)?,
                    }
                }
                return Ok(0.0);
            }
            _ => {}
        }
        inner.call(call)
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        self.inner.get(batch, values)?;
        if let Some((_, means)) = &self.plan.means {
            let known = &self.work.borrow().tracked.means;
            for (variable, value) in batch.variables.iter().zip(values) {
                let place = means.iter().position(|mean| mean == variable);
                let mean = place.map(|place| known[place]);
                *value = mean.filter(|mean| !mean.is_nan()).unwrap_or(*value);
            }
        }
        Ok(())
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        match self.note(batch, |k| Some(values[k].to_bits()))? {
            true => self.inner.set(batch, values),
            false => Ok(()),
        }
    }

    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        self.inner.get_derivatives(batch, values)
    }

    /// The inputs are on a line from now on, until they are set again.
    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        let work = &mut *self.work.borrow_mut();
        let variables = &batch.variables;
        let known = work
            .ramps
            .iter()
            .position(|ramp| ramp.sources.is_empty() && ramp.batch.variables == *variables);
        let place = known.unwrap_or_else(|| {
            let zeros = vec![0.0; values.len()];
            let ramp = Ramp::new(batch, &[], [zeros.clone(), zeros]);
            work.ramps.push(ramp);
            work.ramps.len() - 1
        });
        let (ramp, given) = (&mut work.ramps[place], &work.tracked.given);
        ramp.start = work.tracked.time;
        ramp.rates.copy_from_slice(values);
        for (value, variable) in ramp.values.iter_mut().zip(variables) {
            *value = f64::from_bits(given[*variable].unwrap_or_default());
        }
        work.tracked.is_changed = true;
        Ok(())
    }

    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()> {
        self.inner.directional(of, seeds, rates)
    }

    fn integration(&self) -> Result<Option<Integration>> {
        let work = self.work.borrow();
        let counts = work.integrator.counts();
        Ok(Some(Integration {
            steps: counts.steps,
            rejected: counts.rejected,
            jacobians: counts.jacobians,
            evaluations: work.tracked.evaluations,
            events: work.tracked.events,
            stiff_since: work.tracked.stiff_since,
        }))
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        Ok(Box::new(Saved {
            inner: self.inner.save()?,
            tracked: self.work.borrow().save(),
        }))
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        let saved: &Saved = state
            .downcast_ref()
            .context("a state of another instance")?;
        self.inner.restore(&*saved.inner)?;
        self.work.borrow_mut().restore(&saved.tracked)
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        let saved: &Saved = state
            .downcast_ref()
            .context("a state of another instance")?;
        let mut bytes = postcard::to_stdvec(&saved.tracked)?;
        bytes.extend(self.inner.state_to_bytes(&*saved.inner)?);
        Ok(bytes)
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        let (tracked, own) = postcard::take_from_bytes(bytes)?;
        let inner = self.inner.state_from_bytes(own)?;
        Ok(Box::new(Saved { inner, tracked }))
    }

    fn reset(&self) -> bool {
        *self.work.borrow_mut() = Work::new(&self.plan);
        self.inner.reset()
    }
}
