//! The instances of a run with the plans of what is passed between them, made and saved by the
//! master. The schedules are made of the operations here: pass values, step components, handle
//! events, account for power bonds. These operations look nothing up and allocate nothing.

use anyhow::{Error, Result, bail, ensure};
use serde::{Deserialize, Serialize};

use crate::exchange::balance::Balance;
use crate::exchange::bond::{BondSlots, BondStep, Residual};
use crate::exchange::means::Means;
use crate::exchange::ticks::Ticks;
use crate::exchange::unconnected::Unconnected;
use crate::exchange::{Exchange, ExchangeState};
use crate::instance::{At, BegunCall, Call, Ended, Failure, Instance, State, all};
use crate::schedule::rates::{ComponentStep, PastValues, Rates};

/// Passes of Event Mode after which discrete states that still change are an error.
const MAX_PASSES: usize = 100;

/// The instances of a run with their plans.
pub(crate) struct Coupling {
    pub instances: Vec<Instance>,
    /// Ranks of components that Gauss–Seidel may step at the same time: a component is in a later
    /// rank than those whose mean effort it gets. Components of this thread come first in a rank.
    pub ranks: Vec<Vec<usize>>,
    /// Components with an Event Mode, which may have events at times of their own.
    pub timed: Vec<usize>,
    /// A component that cannot vary its step.
    pub fixed: Option<String>,
    pub exchange: Exchange,
    pub ticks: Ticks,
    pub unconnected: Unconnected,
    /// Set if components have steps of their own, or inputs that are not held.
    pub rates: Option<Rates>,
    /// Set if the inputs of power bonds are corrected.
    pub balance: Option<Balance>,
    /// Set if the schedule passes derivatives.
    pub derivatives: Option<Exchange>,
    pub means: Means,
    pub bonds: Vec<BondSlots>,
    pub residuals: Vec<Residual>,
    pub bond_steps: Vec<BondStep>,
    /// An FMU asked to end the simulation after the present step.
    pub ended: Failure,
}

/// State of the instances and the plans at a communication point; `S` is the state of an instance,
/// or its bytes.
#[derive(Deserialize, Serialize)]
pub(crate) struct Saved<S = State> {
    instances: Vec<S>,
    passed: ExchangeState,
    nonfinite: Vec<Option<[f64; 2]>>,
    derivatives: Option<ExchangeState>,
    means: Vec<f64>,
    residuals: Vec<Residual>,
    bond_steps: Vec<BondStep>,
    rates: Option<PastValues>,
}

impl<S> Saved<S> {
    /// The same with the state of each instance converted.
    fn convert<T>(
        self,
        coupling: &Coupling,
        convert: impl Fn(&Instance, S) -> Result<T>,
    ) -> Result<Saved<T>> {
        ensure!(
            self.instances.len() == coupling.instances.len(),
            "a state of another run"
        );
        let instances = coupling.instances.iter().zip(self.instances);
        let instances = instances.map(|(instance, state)| convert(instance, state));
        Ok(Saved {
            instances: instances.collect::<Result<_>>()?,
            passed: self.passed,
            nonfinite: self.nonfinite,
            derivatives: self.derivatives,
            means: self.means,
            residuals: self.residuals,
            bond_steps: self.bond_steps,
            rates: self.rates,
        })
    }
}

impl Coupling {
    /// The state at `t`, s, with the states of the instances as bytes.
    pub fn save_bytes(&self, t: f64) -> Result<Saved<Vec<u8>>> {
        self.save(t)?.convert(self, |instance, state| {
            instance.state_to_bytes(&state, At::Time(t))
        })
    }

    /// Back to a state from [`Coupling::save_bytes`].
    pub fn restore_bytes(&mut self, saved: Saved<Vec<u8>>, t: f64) -> Result<()> {
        ensure!(
            self.exchange.fits(&saved.passed)
                && self.unconnected.found.len() == saved.nonfinite.len()
                && self.derivatives.is_some() == saved.derivatives.is_some()
                && self.means.values.len() == saved.means.len()
                && self.residuals.len() == saved.residuals.len()
                && self.rates.is_some() == saved.rates.is_some(),
            "a state of a system or of faults that differ from these"
        );
        let saved = saved.convert(self, |instance, bytes| {
            instance.state_from_bytes(&bytes, At::Time(t))
        })?;
        self.restore(&saved, t)
    }

    /// The state at `t`, s.
    pub fn save(&self, t: f64) -> Result<Saved> {
        let instances = self.instances.iter().map(|s| s.save(At::Time(t)));
        Ok(Saved {
            instances: instances.collect::<Result<_>>()?,
            passed: self.exchange.save(),
            nonfinite: self.unconnected.found.clone(),
            derivatives: self.derivatives.as_ref().map(Exchange::save),
            means: self.means.values.clone(),
            residuals: self.residuals.clone(),
            bond_steps: self.bond_steps.clone(),
            rates: self.rates.as_ref().map(|rates| rates.known.clone()),
        })
    }

    /// Back to a state at `t`, s.
    pub fn restore(&mut self, saved: &Saved, t: f64) -> Result<()> {
        ensure!(
            saved.instances.len() == self.instances.len(),
            "a state of another run"
        );
        for (instance, state) in self.instances.iter().zip(&saved.instances) {
            instance.restore(state, At::Time(t))?;
        }
        self.ended = Failure::default();
        self.exchange.restore(&saved.passed);
        // Passing a tick once more in the same instant changes nothing.
        self.ticks.begin_instant();
        self.unconnected.found.clone_from(&saved.nonfinite);
        for (exchange, passed) in self.derivatives.iter_mut().zip(&saved.derivatives) {
            exchange.restore(passed);
        }
        self.means.values.clone_from(&saved.means);
        self.residuals.clone_from(&saved.residuals);
        self.bond_steps.clone_from(&saved.bond_steps);
        for (rates, known) in self.rates.iter_mut().zip(&saved.rates) {
            rates.known.clone_from(known);
        }
        Ok(())
    }

    /// Read all outputs at `t`, s.
    pub fn read(&mut self, t: f64) -> Result<()> {
        self.exchange.read(&self.instances, At::Time(t))
    }

    /// Read the outputs that no connection passes on, before any input is set.
    pub fn watch_unconnected(&mut self, t: f64) -> Result<()> {
        let resting = &self.exchange.resting;
        self.unconnected.read(&self.instances, resting, t)
    }

    /// Pass all connections, stage by stage, and ticks of clocks.
    pub fn pass(&mut self, t: f64) -> Result<()> {
        self.exchange.run(&self.instances, At::Time(t))?;
        self.pass_ticks(t)
    }

    /// Pass ticks and clocked values, and all connections after them, until no further clock ticks
    /// in this instant.
    fn pass_ticks(&mut self, t: f64) -> Result<()> {
        while self.pass_clocked(t)? {
            self.exchange.run_again(&self.instances, At::Time(t))?;
        }
        Ok(())
    }

    /// Pass all connections once more at the same communication point, and the derivatives, which
    /// an input loses when it is set.
    pub fn pass_again(&mut self, t: f64) -> Result<()> {
        self.exchange.run_again(&self.instances, At::Time(t))?;
        self.pass_ticks(t)?;
        self.pass_derivatives(t)
    }

    /// Pass first time derivatives, if the schedule has them.
    pub fn pass_derivatives(&mut self, t: f64) -> Result<()> {
        let faults = self.exchange.faults.as_ref();
        match &mut self.derivatives {
            Some(plan) => plan.run_derivatives(&self.instances, faults, At::Time(t)),
            None => Ok(()),
        }
    }

    /// Set the component's inputs to the mean efforts of components stepped before it.
    fn give_means(&mut self, component: usize, t: f64) -> Result<()> {
        let Some(write) = &mut self.means.writes[component] else {
            return Ok(());
        };
        let faults = self.exchange.faults.as_mut();
        write.run(&self.instances, &self.means.values, faults, At::Time(t))
    }

    /// Step a component from `t` by `h`, s, and read the mean efforts that it exerted.
    fn step_component(&mut self, component: usize, t: f64, h: f64) -> Result<()> {
        if self.rates.is_some() {
            let done = self.step_at_own_rate(component, [t, h], false);
            return done.or_else(|error| self.end_after(component, error, t + h));
        }
        if let Err(error) = self.instances[component].step(t, h) {
            return self.end_after(component, error, t + h);
        }
        match &self.means.reads[component] {
            Some(read) => read.run(&self.instances, &mut self.means.values, At::Time(t)),
            None => Ok(()),
        }
    }

    /// The error of a component's step to `end`, s, unless the FMU has made the step and asks to
    /// end the simulation: the run then ends once the others have made it, too.
    #[cold]
    pub fn end_after(&mut self, component: usize, error: Error, end: f64) -> Result<()> {
        match error.downcast_ref::<Ended>() {
            Some(ended) if ended.is_after_step(end) => {
                self.ended.add(component, Err(error));
                Ok(())
            }
            _ => Err(error),
        }
    }

    /// Make the steps of a component that has steps of its own, or begin them in its thread.
    fn step_at_own_rate(&mut self, component: usize, time: [f64; 2], begins: bool) -> Result<()> {
        let Some(rates) = &mut self.rates else {
            return Ok(());
        };
        let steps = ComponentStep {
            component,
            instances: &self.instances,
            values: &self.exchange.values,
            mean: self.means.reads[component].as_ref(),
            means: &mut self.means.values,
            faults: self.exchange.faults.as_mut(),
            begins,
        };
        rates.step(steps, time)
    }

    /// Step all components: with `gives_means` one after the other, passing mean efforts on, else
    /// all from the same values.
    pub fn step_all(&mut self, t: f64, h: f64, gives_means: bool) -> Result<()> {
        if let Some(balance) = &mut self.balance {
            let bonds = self.bonds.iter().zip(&self.bond_steps);
            balance.set(bonds, &self.instances, &mut self.exchange, [t, h])?;
        }
        if let Some(rates) = &self.rates {
            rates.rest(&mut self.exchange.resting, t + h);
        }
        // With faults, the order of components is also the order of their random numbers.
        if !self.exchange.is_multi_threaded || gives_means && self.exchange.faults.is_some() {
            for k in 0..self.instances.len() {
                if gives_means {
                    self.give_means(k, t)?;
                }
                self.step_component(k, t, h)?;
            }
        } else {
            let ranks = std::mem::take(&mut self.ranks);
            let mut ranked = ranks.iter();
            let done = ranked.try_for_each(|rank| self.step_in_threads(rank, [t, h], gives_means));
            self.ranks = ranks;
            done?;
        }
        if let Some(rates) = &mut self.rates {
            rates.remember(&self.exchange.values, h);
        }
        Ok(())
    }

    /// Step a rank: components of other threads are begun first, then those of this one are
    /// stepped.
    fn step_in_threads(
        &mut self,
        rank: &[usize],
        [t, h]: [f64; 2],
        gives_means: bool,
    ) -> Result<()> {
        let mut failure = Failure::default();
        let is_elsewhere = |coupling: &Self, k: usize| coupling.instances[k].is_elsewhere();
        for k in rank.iter().copied() {
            if is_elsewhere(self, k) {
                failure.add(k, self.begin_step(k, [t, h], gives_means));
            }
        }
        for k in rank.iter().copied() {
            let given = match gives_means {
                true => self.give_means(k, t),
                false => Ok(()),
            };
            let done = given.and_then(|()| self.step_component(k, t, h));
            self.instances[k].drain();
            failure.add(k, done);
        }
        failure.into()
    }

    /// Begin what [`Coupling::give_means`] and [`Coupling::step_component`] then end.
    fn begin_step(&mut self, k: usize, [t, h]: [f64; 2], gives_means: bool) -> Result<()> {
        let (at, instances) = (At::Time(t), &self.instances);
        let means = &mut self.means;
        if let Some(write) = means.writes[k].as_mut().filter(|_| gives_means) {
            write.begin(instances, &means.values, None, at)?;
        }
        if self.rates.is_some() {
            return self.step_at_own_rate(k, [t, h], true);
        }
        instances[k].begin(BegunCall::Plain(Call::Step(t, h)));
        if let Some(read) = &self.means.reads[k] {
            read.begin(instances);
        }
        Ok(())
    }

    /// The instances that have an Event Mode.
    fn timed(&self) -> impl Iterator<Item = &Instance> + Clone {
        self.timed.iter().map(|k| &self.instances[*k])
    }

    /// All instances enter Event Mode, if they have one.
    pub fn enter_events(&self, t: f64) -> Result<()> {
        all(self.timed(), Call::EnterEvents, At::Time(t)).map(drop)
    }

    /// All instances leave Event Mode together: values are passed again until no discrete state
    /// changes and no connected clock ticks.
    pub fn leave_events(&mut self, t: f64) -> Result<()> {
        self.leave_events_after(t, Self::pass_again)
    }

    /// The same with these passes between updates.
    fn leave_events_after(
        &mut self,
        t: f64,
        pass: impl Fn(&mut Self, f64) -> Result<()>,
    ) -> Result<()> {
        let at = At::Time(t);
        for _ in 0..MAX_PASSES {
            let is_again = all(self.timed(), Call::UpdateEvents, at)? != 0.0;
            self.ticks.begin_instant();
            if !is_again {
                return all(self.timed(), Call::LeaveEvents, at).map(drop);
            }
            pass(self, t)?;
        }
        let is_changing = |s: &&Instance| !matches!(s.call(Call::UpdateEvents, at), Ok(0.0));
        let changing = self.timed().filter(is_changing);
        let names: Vec<_> = changing.map(|s| s.name.as_str()).collect();
        let ticks = match self.ticks.ticking().join(", ") {
            none if none.is_empty() => none,
            names => format!(", and clocks tick: {names}"),
        };
        bail!(
            "{at}: discrete states of {} still change after {MAX_PASSES} passes of Event Mode{ticks}",
            names.join(", ")
        )
    }

    /// With the schedule `standard`: the instances that are in Event Mode leave it. Each does so by
    /// itself, unless clocks are connected: then ticks take others into Event Mode, and those that
    /// are in it pass values to each other.
    pub fn settle(&mut self, t: f64) -> Result<()> {
        let at = At::Time(t);
        if self.ticks.is_empty() {
            return (self.timed()).try_for_each(|s| s.call(Call::Settle, at).map(drop));
        }
        if all(self.timed(), Call::InEvents, at)? == 0.0 {
            return Ok(());
        }
        self.pass_clocked(t)?;
        self.leave_events_after(t, |coupling, t| coupling.pass_clocked(t).map(drop))?;
        // Nothing was set since in those that were in Event Mode.
        let in_events = std::mem::take(&mut self.ticks.in_events);
        let mut all = in_events.iter();
        let read = all.try_for_each(|k| self.exchange.read_component(*k, &self.instances, at));
        self.ticks.in_events = in_events;
        read
    }

    /// Pass ticks, and clocked values between instances that are in Event Mode, until neither has
    /// news; returns whether there were ticks that were not passed in this instant yet.
    fn pass_clocked(&mut self, t: f64) -> Result<bool> {
        let (at, mut is_any) = (At::Time(t), false);
        if self.ticks.is_empty() {
            return Ok(false);
        }
        for _ in 0..MAX_PASSES {
            let mut has_news = self.ticks.pass(&self.instances, at)?;
            is_any |= has_news;
            let in_events = &mut self.ticks.in_events;
            in_events.clear();
            for k in self.timed.iter().copied() {
                if self.instances[k].call(Call::InEvents, at)? != 0.0 {
                    in_events.push(k);
                }
            }
            if !self.ticks.has_passed() {
                return Ok(false);
            }
            let (values, exact) = &mut self.ticks.before;
            values.clone_from(&self.exchange.values);
            self.exchange.copy_exact(exact);
            for k in &self.ticks.in_events {
                self.exchange.read_clocked(*k, &self.instances, at)?;
            }
            let (values, exact) = &self.ticks.before;
            has_news |= !self.exchange.has_same(values, exact);
            if !has_news {
                return Ok(is_any);
            }
            for k in &self.ticks.in_events {
                self.exchange.write_clocked(*k, &self.instances, at)?;
            }
        }
        bail!(
            "{at}: clocked values still change after {MAX_PASSES} passes in one instant of Event Mode: they depend on each other in a loop"
        )
    }

    /// Time of the first event after `start` and before `end`, both s, at which the step is split; None
    /// if a component cannot vary its step. An event at `start` that is announced anew, by an FMU whose
    /// own time is earlier by rounding, is left to its next step.
    pub fn split(&self, start: f64, end: f64) -> Option<f64> {
        let all = self.timed().map(Instance::next_event);
        let first = all.filter(|t| *t > start).reduce(f64::min)?;
        (first < end && self.fixed.is_none()).then_some(first)
    }

    /// Name of the component whose event comes first.
    pub fn first_to_split(&self) -> &str {
        let all = self.timed();
        let first = all.min_by(|a, b| a.next_event().total_cmp(&b.next_event()));
        first.map_or("", |instance| &instance.name)
    }

    /// Tick the clocks that are due at `t` within `tolerance`, both s, and pass what they change.
    /// With a staged exchange the instances are in Event Mode before and after.
    pub fn tick(&mut self, t: f64, tolerance: f64, is_staged: bool) -> Result<()> {
        let (at, mut is_any) = (At::Time(t), false);
        for k in self.timed.iter().copied() {
            let instance = &self.instances[k];
            if instance.next_event() > t + tolerance {
                continue;
            }
            is_any = true;
            if !is_staged {
                self.exchange.write_component(k, &self.instances, at)?;
            }
            instance
                .call(Call::Tick(t, tolerance), at)
                .map_err(|error| match &self.fixed {
                    Some(fixed) => error.context(format!(
                        "the step cannot be split, because `{fixed}` cannot vary its step"
                    )),
                    None => error,
                })?;
            if !is_staged && self.ticks.is_empty() {
                instance.call(Call::Settle, at)?;
                self.exchange.read_component(k, &self.instances, at)?;
            }
        }
        if !is_staged && !self.ticks.is_empty() {
            return self.settle(t);
        }
        match is_staged {
            true => self.complete_events(t, is_any),
            false => Ok(()),
        }
    }

    /// Complete the events at `t`, s, of a staged exchange, and pass what they change, until none
    /// follows.
    fn complete_events(&mut self, t: f64, has_ticked: bool) -> Result<()> {
        let at = At::Time(t);
        if has_ticked {
            self.pass_again(t)?;
        }
        let mut is_due = has_ticked;
        for _ in 0..MAX_PASSES {
            if !is_due && all(self.timed(), Call::InEvents, at)? < 2.0 {
                return Ok(());
            }
            is_due = false;
            self.leave_events(t)?;
            self.enter_events(t)?;
            self.pass_again(t)?;
        }
        bail!("{at}: events still follow each other after {MAX_PASSES} passes of all connections")
    }

    /// Record the mean effort and flow that the components were given, before the next exchange
    /// overwrites them. With `gives_means` a component that was stepped later was given the mean
    /// effort.
    pub fn record_bonds(&mut self, h: f64, gives_means: bool) {
        let (half, derivatives) = (0.5 * h, self.derivatives.as_ref());
        let rise = |slot: Option<usize>| {
            let both = derivatives.zip(slot);
            both.map_or(0.0, |(d, slot)| half * d.values[slot])
        };
        for (k, (bond_step, bond)) in self.bond_steps.iter_mut().zip(&self.bonds).enumerate() {
            let mean = self.means.values[bond.mean_slot];
            let effort_exerted = bond.transformation.apply(mean);
            let effort_before = self.exchange.values[bond.effort_slot];
            let flow_before = self.exchange.values[bond.flow_slot];
            let balance = self.balance.as_ref();
            let before = [effort_before, flow_before];
            let [effort, flow] = balance.map_or(before, |balance| balance.given(k));
            let held = effort + rise(bond.derivative_slots.0);
            let held = bond.transformation.apply(held);
            let effort_given = match gives_means && bond.mean_given {
                true => effort_exerted,
                false => held,
            };
            let flow_given = flow + rise(bond.derivative_slots.1);
            *bond_step = BondStep {
                effort_exerted,
                flow_given,
                effort_given,
                flow_before,
                length: h,
                effort_lacked: mean - effort_before,
                flow_lacked: 0.0,
            };
        }
    }

    /// Add the step to the bonds' residuals, once the flows at its end have been read.
    pub fn account(&mut self, h: f64) {
        let bonds = self.bond_steps.iter_mut().zip(&self.bonds);
        for (residual, (given, bond)) in self.residuals.iter_mut().zip(bonds) {
            let moved = 0.5 * (given.flow_before + self.exchange.values[bond.flow_slot]);
            given.flow_lacked = moved - given.flow_before;
            let exerted = given.effort_exerted * given.flow_given;
            residual.add(h, bond.power, exerted, given.effort_given * moved);
        }
    }
}
