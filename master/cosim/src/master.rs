//! The co-simulation master: makes and initializes the instances of a system, steps them by a
//! schedule, and saves and restores the state of the whole. Runs, scripts and pages step it.

use std::collections::{BTreeSet, HashSet};

use anyhow::{Context, Error, Result, bail, ensure};
use fmi_description::{Access, Variability};
use serde::{Deserialize, Serialize};

use crate::exchange::balance::Balance;
use crate::exchange::bond::{BondStep, Residual};
use crate::exchange::coupling::{self, Coupling};
use crate::exchange::faults::{Alteration, Faults, is_source};
use crate::exchange::means::Means;
use crate::exchange::ticks::Ticks;
use crate::exchange::unconnected::Unconnected;
use crate::exchange::whole_steps::WholeSteps;
use crate::exchange::{Exchange, Order};
use crate::instance::{At, Call, Ended, Failure, Instance, State, all};
use crate::io::input_table::InputTable;
use crate::run::instance_cache;
use crate::run::instances::make;
use crate::run::verdict::Verdict;
use crate::schedule::rates::Rates;
use crate::schedule::thread_plan::ThreadPlan;
use crate::schedule::{self, Between};
use crate::structure::system::{Setting, System};
use crate::wiring::{Link, Port, Wiring};
use fmi_import::digits::short;
use fmi_import::raw::Experiment as FmiExperiment;

pub use crate::run::instances::{instantiate, start_value};
pub use crate::schedule::{Jitter, Schedule, Stepping};

/// Part of the communication step within which an event counts as met.
const TOLERANCE: f64 = 1e-6;
/// Events in a row, each within that time of the one before, after which they count as endless.
const MAX_CROWDED: u32 = 1000;

/// A running system.
pub struct Master {
    coupling: Coupling,
    /// Set if threads make whole steps in the schedule `standard`.
    whole_steps: Option<WholeSteps>,
    stepping: Stepping,
    steps: u64,
    /// Present time, s.
    time: f64,
    inputs: Option<InputTable>,
    /// The last communication step, if steps have variable length.
    pub last_step: LastStep,
}

/// The saved state of a running system at a communication point, with the instances' states, or
/// their bytes.
#[derive(Deserialize, Serialize)]
pub struct Saved<S = State> {
    coupling: coupling::Saved<S>,
    steps: u64,
    time: f64,
    last_step: LastStep,
}

/// Length and error of the last communication step, if steps have variable length.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct LastStep {
    /// Length, s.
    pub length: f64,
    /// Error relative to the allowed one.
    pub error: f64,
}

impl Master {
    /// Instantiates and initializes all components of `system`, with the structure's parameter
    /// values, then `settings`; afterwards all connections are passed at the start time.
    pub fn new(system: &System, settings: &[Setting], stepping: Stepping) -> Result<Self> {
        Self::with_threads(system, settings, stepping, 1)
    }

    /// The same with several threads.
    pub fn with_threads(
        system: &System,
        settings: &[Setting],
        stepping: Stepping,
        threads: usize,
    ) -> Result<Self> {
        let experiment = FmiExperiment::from_start(stepping.start);
        Self::for_experiment(system, settings, stepping, threads, experiment, &[])
    }

    /// The same where the FMUs are `told` start, stop and tolerance. The variables `nonfinite`, and
    /// inputs that they drive, may have values that are not finite.
    pub(crate) fn for_experiment(
        system: &System,
        settings: &[Setting],
        stepping: Stepping,
        threads: usize,
        told: FmiExperiment,
        nonfinite: &[Port],
    ) -> Result<Self> {
        let Stepping { start, step, .. } = stepping;
        ensure!(
            step.is_finite() && step > 0.0 && start.is_finite(),
            "step {} s from {} s: both must be finite and the step > 0",
            short(step),
            short(start)
        );
        let wiring = system.wiring()?;
        let is_staged = stepping.schedule != Schedule::Standard;
        let is_sequential = stepping.schedule == Schedule::GaussSeidel;
        let has_ends = matches!(stepping.between, Between::Interpolated | Between::End);
        let order = match is_staged {
            true => Order::Stages,
            false => Order::AtOnce,
        };
        let mut exchange = Exchange::new(&wiring, order, |_| true)?;
        let derivatives = match stepping.schedule {
            Schedule::JacobiDerivatives => {
                let passes = |link: &Link| {
                    let mut terms = wiring.terms(link.to);
                    terms.all(|term| passes_derivative(&wiring, term))
                };
                Some(Exchange::new(&wiring, Order::Stages, passes)?)
            }
            _ => None,
        };
        let rates = Rates::new(&system.structure, &wiring, &exchange, stepping)?;
        let balance = Balance::new(&wiring, stepping, rates.is_some())?;
        let (means, bonds) = Means::new(&wiring, &exchange, derivatives.as_ref())?;
        let parts = Rates::most_parts(&system.structure, step);
        let thread_plan = ThreadPlan::new(system, threads, parts)?;
        let mut nonfinite: BTreeSet<Port> = nonfinite.iter().copied().collect();
        for link in &wiring.links {
            if nonfinite.contains(&link.from) {
                nonfinite.insert(link.to);
            }
        }
        let worker = |k| thread_plan.worker(k);
        let stages = (is_staged, stepping.repeats);
        let make = |k| make(system, k, settings, stages, told, worker(k), &nonfinite);
        let instances: Vec<Instance> = (0..system.fmus.len()).map(make).collect::<Result<_>>()?;
        exchange.is_multi_threaded = instances.iter().any(Instance::is_elsewhere);
        initialize(&instances, &wiring, stepping)?;
        let residuals = bonds.iter().map(|b| Residual::new(wiring.name(b.effort)));
        let timed = (0..instances.len()).filter(|k| instances[*k].has_events);
        let mut coupling = Coupling {
            timed: timed.collect(),
            residuals: residuals.collect(),
            fixed: system.fixed_step().map(str::to_string),
            bond_steps: vec![BondStep::default(); bonds.len()],
            ranks: thread_plan.ranks(&wiring, |link| {
                is_sequential && (link.bond.is_some() || has_ends)
            }),
            unconnected: Unconnected::new(&wiring, &exchange, &instances),
            instances,
            ticks: Ticks::new(&wiring),
            rates,
            exchange,
            balance,
            derivatives,
            means,
            bonds,
            ended: Failure::default(),
        };
        if coupling.exchange.over_step.is_some() {
            // Refuses now rather than in the first step.
            coupling.save(start).context(
                "loops are solved by repeated steps with the schedule standard, for which every component must save its state",
            )?;
        }
        let whole_steps = match is_staged {
            true => None,
            false => WholeSteps::new(&coupling),
        };
        schedule::begin(stepping.schedule, &mut coupling, start)?;
        coupling.tick(start, TOLERANCE * step, is_staged)?;
        Ok(Self {
            coupling,
            whole_steps,
            stepping,
            steps: 0,
            time: start,
            inputs: None,
            last_step: LastStep::default(),
        })
    }

    /// From now on a component that ends a step early stops the step of all.
    pub(crate) fn stop_early(&self) {
        self.instances().iter().for_each(Instance::stop_early);
    }

    /// Present time, s: `t_0 + k·h` after k steps.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of steps made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Values of all connected outputs as last exchanged; [`Exchange::slot`] says which is where.
    pub fn exchange(&self) -> &Exchange {
        &self.coupling.exchange
    }

    /// Start, communication step and schedule.
    pub fn stepping(&self) -> Stepping {
        self.stepping
    }

    /// Present value of a numeric variable.
    pub fn number(&self, port: Port) -> Result<f64> {
        self.coupling.instances[port.component].number(port.variable, At::Time(self.time))
    }

    /// Present value, as text, of a variable whose type is no number.
    pub fn text(&self, port: Port) -> Result<String> {
        let value = self.instances()[port.component].value(port.variable, At::Time(self.time));
        Ok(value?.to_string())
    }

    /// The instances, in the order of the structure's components.
    pub fn instances(&self) -> &[Instance] {
        &self.coupling.instances
    }

    /// From now on these faults, and no others, alter values; those of the present time are passed
    /// again. An input in a scenario that nothing drives keeps its present value apart from the faults.
    pub fn apply_faults(&mut self, system: &System, faults: &Faults) -> Result<()> {
        let wiring = system.wiring()?;
        let mut fed: HashSet<Port> = self.fed().iter().copied().collect();
        for fault in faults.list.iter().filter(|fault| fault.is_event) {
            let (port, is_source) = (fault.port, is_source(system, fault.port));
            if !is_source && wiring.driver(port).is_none() && fed.insert(port) {
                let (value, time) = (self.number(port)?, self.time);
                let table = self.inputs.get_or_insert_with(|| InputTable::empty(time));
                table.hold(&wiring, port, value);
            }
        }
        faults.describe(system, &wiring, self.fed())?;
        let mut alteration = Alteration::new(system, faults, self.stepping)?;
        let plans = &mut self.coupling;
        let rates = plans.rates.iter_mut().flat_map(|r| &mut r.components);
        let writes = (plans.exchange.writes())
            .chain(plans.derivatives.iter_mut().flat_map(Exchange::writes))
            .chain(plans.means.writes.iter_mut().flatten())
            .chain(plans.balance.iter_mut().flat_map(|b| &mut b.writes))
            .chain(rates.flat_map(|rate| &mut rate.writes))
            .chain(self.inputs.iter_mut().flat_map(|table| &mut table.writes));
        writes.for_each(|write| write.attach(&wiring, &mut alteration));
        self.coupling.exchange.faults = (!faults.list.is_empty()).then_some(alteration);
        self.set_inputs()?;
        self.pass()
    }

    /// Inputs that are driven by a table.
    fn fed(&self) -> &[Port] {
        self.inputs.as_ref().map_or(&[], InputTable::ports)
    }

    /// Passes all connections again at the present time, after inputs that no connection drives
    /// were set. Does nothing with [`Schedule::Standard`], whose next step passes them.
    pub fn pass(&mut self) -> Result<()> {
        if self.stepping.schedule == Schedule::Standard {
            return Ok(());
        }
        self.coupling.pass_again(self.time)
    }

    /// Findings on outputs that no connection passes on and that were not finite.
    pub(crate) fn judge_unconnected(&self, system: &System, verdict: &mut Verdict) {
        let unconnected = &self.coupling.unconnected;
        for (port, [time, value]) in unconnected.nonfinite() {
            let name = system.name(port);
            verdict.object(format!(
                "the output `{name}` became {value} at t = {time} s; no connection passes it on (--allow-nonfinite {name} where that is \
                 meant)"
            ));
        }
        let remarks = unconnected.remarks.iter().cloned();
        remarks.for_each(|remark| verdict.note(remark));
    }

    /// Power residuals of the bonds so far.
    pub fn residuals(&self) -> &[Residual] {
        &self.coupling.residuals
    }

    /// One communication step: all components, then the exchange at the new time. Does not allocate
    /// unless it fails.
    pub fn step(&mut self) -> Result<()> {
        let Stepping { start, step, .. } = self.stepping;
        self.advance(step, start + (self.steps + 1) as f64 * step)
    }

    /// A last, shorter communication step that ends at `end`, s.
    pub fn step_to(&mut self, end: f64) -> Result<()> {
        self.advance(end - self.time, end)
    }

    /// Steps by `h` to `end`, both s, in parts if there are events in between.
    fn advance(&mut self, mut h: f64, end: f64) -> Result<()> {
        let Stepping { step, schedule, .. } = self.stepping;
        let (tolerance, mut crowded) = (TOLERANCE * step, 0);
        loop {
            if self.whole_steps.is_none() {
                schedule::prepare(schedule, &mut self.coupling, self.time)?;
            }
            let split = self.coupling.split(self.time, end - tolerance);
            let is_close = split.is_some_and(|t| t - self.time < tolerance);
            crowded = if is_close { crowded + 1 } else { 0 };
            if crowded > MAX_CROWDED {
                bail!(
                    "at t = {} s: `{}` has had {MAX_CROWDED} events in a row, each less than {tolerance} s after the one before: they do not \
                     end",
                    self.time,
                    self.coupling.first_to_split()
                );
            }
            let part = split.map_or([self.time, h, end], |t| [self.time, t - self.time, t]);
            let done = match &mut self.whole_steps {
                Some(whole_steps) => whole_steps.advance(&mut self.coupling, part),
                None => schedule::advance(schedule, &mut self.coupling, part),
            };
            if let Err(error) = done {
                self.reach_end(&error, part[2]);
                return Err(error);
            }
            self.time = part[2];
            self.steps += u64::from(split.is_none());
            Result::from(std::mem::take(&mut self.coupling.ended))?;
            self.set_inputs()?;
            let is_staged = schedule != Schedule::Standard;
            self.coupling.tick(self.time, tolerance, is_staged)?;
            if split.is_none() {
                return Ok(());
            }
            h = end - self.time;
        }
    }

    /// After a step to `end`, s, within which an FMU asked to end the simulation: the present time is
    /// the one that all instances have reached.
    #[cold]
    fn reach_end(&mut self, error: &Error, end: f64) {
        if let Some(ended) = error.downcast_ref::<Ended>()
            && (self.instances().len() == 1 || ended.is_after_step(end))
            && ended.time > self.time
        {
            self.time = ended.time;
        }
    }

    /// At the present time and from now on, inputs that no connection drives get the values of a
    /// table.
    pub fn feed(&mut self, inputs: InputTable) -> Result<()> {
        self.inputs = Some(inputs);
        self.set_inputs()
    }

    fn set_inputs(&mut self) -> Result<()> {
        let Some(inputs) = &mut self.inputs else {
            return Ok(());
        };
        let faults = self.coupling.exchange.faults.as_mut();
        inputs.set(&self.coupling.instances, faults, self.time)?;
        self.pass()
    }

    /// Saves the state of all instances and of the values passed between them.
    pub fn save(&self) -> Result<Saved> {
        Ok(self.saved(self.coupling.save(self.time)?))
    }

    /// The same in bytes, for a run of the same system in another process.
    pub(crate) fn save_bytes(&self) -> Result<Saved<Vec<u8>>> {
        Ok(self.saved(self.coupling.save_bytes(self.time)?))
    }

    fn saved<S>(&self, coupling: coupling::Saved<S>) -> Saved<S> {
        Saved {
            coupling,
            steps: self.steps,
            time: self.time,
            last_step: self.last_step,
        }
    }

    /// Restores the state from bytes.
    pub(crate) fn restore_bytes(&mut self, saved: Saved<Vec<u8>>) -> Result<()> {
        self.coupling.restore_bytes(saved.coupling, saved.time)?;
        self.resume(saved.steps, saved.time, saved.last_step);
        Ok(())
    }

    /// Restores a saved state of this run, which then continues from there as it did, bit for bit.
    pub fn restore(&mut self, saved: &Saved) -> Result<()> {
        self.coupling.restore(&saved.coupling, saved.time)?;
        self.resume(saved.steps, saved.time, saved.last_step);
        Ok(())
    }

    fn resume(&mut self, steps: u64, time: f64, last_step: LastStep) {
        (self.steps, self.time, self.last_step) = (steps, time, last_step);
        self.inputs.iter_mut().for_each(InputTable::rewind);
    }

    /// Terminates all instances.
    pub fn terminate(self) -> Result<()> {
        let (instances, at) = (self.coupling.instances, At::Time(self.time));
        for instance in &instances {
            instance.call(Call::Terminate, at)?;
        }
        instance_cache::keep(instances);
        Ok(())
    }
}

/// An output's derivative is passed if the source has it, the target uses it and the signal is
/// continuous.
fn passes_derivative(wiring: &Wiring, link: &Link) -> bool {
    let [from, to] = [link.from, link.to].map(|end| wiring.description(end.component));
    wiring.access(link.from) == Access::Real
        && !wiring.is_read_once(link.from)
        && from.capabilities.output_derivative_order >= 1
        && to.capabilities.interpolates_inputs
        && wiring.variable(link.from).variability == Variability::Continuous
}

/// Initializes the instances and passes the connections in the order of the initial dependencies,
/// so that the start values of all components agree. If dependencies that are not declared may form
/// a loop, the connections are passed until no value changes; with the schedule `standard` also if
/// declared ones do.
fn initialize(instances: &[Instance], wiring: &Wiring, stepping: Stepping) -> Result<()> {
    let planned = |order| Exchange::new(wiring, order, |_| true);
    let ordered = planned(Order::Initialization);
    let repeated = || match planned(Order::Repeated) {
        Err(_) if stepping.schedule == Schedule::Standard => planned(Order::RepeatedAtOnce),
        planned => planned,
    };
    let enter = Call::EnterInitialization(stepping.start);
    all(instances.iter(), enter, At::Initialization)?;
    match ordered {
        Ok(mut exchange) => {
            exchange.is_multi_threaded = instances.iter().any(Instance::is_elsewhere);
            exchange.run(instances, At::Initialization)?;
        }
        Err(_) => {
            let passes = wiring.links.len() + 1;
            let changing = repeated()?.settle(instances, At::Initialization, passes)?;
            if !changing.is_empty() {
                let names: Vec<_> = changing.iter().map(|port| wiring.name(*port)).collect();
                bail!(
                    "in initialization {} still change after {passes} passes over all connections: they depend on each other in a loop that \
                     these passes do not solve",
                    names.join(", ")
                );
            }
        }
    }
    let exit = Call::ExitInitialization;
    all(instances.iter(), exit, At::Initialization).map(drop)
}
