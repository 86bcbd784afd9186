//! Passes values over a system's connections at every communication point, for the master and its
//! schedules; `cosim wiring` prints the plan. The plan is made once: each stage has one read, then
//! one write per component, type and clocks. Running it neither looks anything up nor allocates.

pub(crate) mod algebraic_loop;
pub(crate) mod balance;
pub mod bond;
pub(crate) mod coupling;
pub mod faults;
pub(crate) mod means;
pub(crate) mod ticks;
mod transfers;
pub(crate) mod unconnected;
pub(crate) mod whole_steps;

use std::collections::{BTreeMap, HashMap};

use crate::exchange::algebraic_loop::{LoopStage, Unknowns};
use crate::exchange::faults::Alteration;
use crate::instance::{At, Failure, Instance};
use crate::wiring::{Feedthrough, Link, Port, Undeclared, Wiring};
use anyhow::Result;
use fmi_description::Access;
use fmi_import::value::{Value, is_non_numeric};
use serde::{Deserialize, Serialize};

pub(crate) use transfers::{Read, Write, reads, writes};

#[derive(Debug, Default)]
struct Stage {
    reads: Vec<Read>,
    writes: Vec<Write>,
    /// Outputs of algebraic loops through this stage.
    unknowns: Option<Unknowns>,
}

/// Which outputs are read before which inputs are set.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Order {
    /// Stages in the order of direct feedthrough in Initialization Mode.
    Initialization,
    /// The same by declared dependencies alone, to be repeated until nothing changes: for systems
    /// that undeclared dependencies would make a loop of.
    Repeated,
    /// One stage in Initialization Mode, to be repeated until nothing changes.
    RepeatedAtOnce,
    /// Stages in the order of direct feedthrough at a communication point, after the outputs that
    /// can be read only once.
    Stages,
    /// One stage: all outputs, then all inputs.
    AtOnce,
}

/// State of an exchange between communication points, for saved states.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct ExchangeState {
    values: Vec<f64>,
    exact: Vec<Value>,
    faults: Option<Alteration>,
}

/// The plan of an exchange, with the values last passed.
#[derive(Debug)]
pub struct Exchange {
    /// Reads right after the step, before any input is set.
    first: Vec<Read>,
    stages: Vec<Stage>,
    slots: BTreeMap<Port, usize>,
    /// Values last passed: one slot per connected output.
    pub values: Vec<f64>,
    /// Values that pass exactly because an f64 cannot hold them (64-bit integers, strings,
    /// binaries), in the same slots; empty if there are none.
    exact: Vec<Value>,
    /// Outputs that depend on each other over a step; with [`Order::AtOnce`] only.
    pub(crate) over_step: Option<Unknowns>,
    /// Instances run in several threads: calls are begun for all before any is ended.
    pub(crate) is_multi_threaded: bool,
    /// Components that have no communication point now; empty if all have one.
    pub(crate) resting: Vec<bool>,
    /// Alterations of the values: faults and scenarios.
    pub(crate) faults: Option<Alteration>,
}

impl Exchange {
    /// Plan the exchange over the connections that `chosen` keeps. An algebraic loop is an error
    /// for the orders with stages.
    pub fn new(wiring: &Wiring, order: Order, chosen: impl Fn(&Link) -> bool) -> Result<Self> {
        let is_initial = !matches!(order, Order::Stages | Order::AtOnce);
        let undeclared = match order {
            Order::Repeated => Undeclared::None,
            _ => Undeclared::All,
        };
        let which = Feedthrough {
            is_initial,
            undeclared,
        };
        let (levels, loops) = match order {
            Order::AtOnce | Order::RepeatedAtOnce => (vec![0; wiring.links.len()], Vec::new()),
            _ => (wiring.levels(which)?, wiring.loops(which)),
        };
        let mut stages = Vec::new();
        let mut slots = BTreeMap::new();
        let is_first = |port: &Port| order == Order::Stages && wiring.is_read_once(*port);
        let is_kept = |link: &Link| chosen(link) && (is_initial || !link.is_initial);
        let kept = wiring.links.iter().filter(|link| is_kept(link));
        let outputs = kept.map(|link| link.from).filter(is_first);
        let first = reads(wiring, outputs, &mut slots);
        let count = levels.iter().max().map_or(1, |last| last + 1);
        // A sum is set once the last of its terms is read.
        let mut sums: HashMap<Port, usize> = HashMap::new();
        for (link, level) in wiring.links.iter().zip(&levels) {
            let last = sums.entry(link.to).or_default();
            *last = (*last).max(*level);
        }
        let mut by_level: Vec<[Vec<&Link>; 2]> = vec![Default::default(); count];
        for (link, level) in wiring.links.iter().zip(&levels) {
            if is_kept(link) {
                by_level[*level][0].push(link);
                by_level[sums[&link.to]][1].push(link);
            }
        }
        let in_loop = loops.iter().flatten().enumerate();
        let in_loop: HashMap<Port, usize> = in_loop.map(|(place, port)| (*port, place)).collect();
        for [links, set] in by_level {
            let outputs = links.iter().map(|link| link.from);
            let outputs = outputs.filter(|port| !is_first(port));
            let reads = reads(wiring, outputs.clone(), &mut slots);
            let mut stage_writes = Vec::new();
            for exact in [false, true] {
                let links = set.iter();
                let own = links.filter(|l| is_non_numeric(wiring.access(l.from)) == exact);
                let inputs = own.map(|l| (l.to, slots[&l.from], l.transformation.clone()));
                let mut planned = writes(wiring, inputs);
                for write in &mut planned {
                    write.is_exact = exact;
                    write.trust_sources();
                }
                stage_writes.extend(planned);
            }
            let in_loops = outputs.filter_map(|port| Some((*in_loop.get(&port)?, port)));
            let in_loops: BTreeMap<usize, Port> = in_loops.collect();
            let in_loops = in_loops.into_values();
            let unknowns = Unknowns::new(wiring, &slots, in_loops)?;
            stages.push(Stage {
                reads,
                writes: stage_writes,
                unknowns,
            });
        }
        let mut over_step = None;
        if order == Order::AtOnce {
            let loops = wiring.loops(Feedthrough {
                is_initial: false,
                undeclared: Undeclared::AllOverStep,
            });
            let outputs = loops.into_iter().flatten();
            let outputs = outputs.filter(|port| wiring.is_continuous(*port));
            over_step = Unknowns::new(wiring, &slots, outputs)?;
        }
        let is_exact = |port: &Port| is_non_numeric(wiring.access(*port));
        let count = slots.len() * usize::from(slots.keys().any(is_exact));
        let exact = vec![Value::empty(Access::Int64); count];
        Ok(Self {
            first,
            stages,
            values: vec![0.0; slots.len()],
            exact,
            slots,
            over_step,
            is_multi_threaded: false,
            resting: Vec::new(),
            faults: None,
        })
    }

    /// The present state.
    pub(crate) fn save(&self) -> ExchangeState {
        ExchangeState {
            values: self.values.clone(),
            exact: self.exact.clone(),
            faults: self.faults.clone(),
        }
    }

    /// Whether a state is of an exchange of the same values with the same alterations.
    pub(crate) fn fits(&self, passed: &ExchangeState) -> bool {
        let sizes = [self.values.len(), self.exact.len()];
        let altered = match (&self.faults, &passed.faults) {
            (Some(own), Some(other)) => own.is_like(other),
            (own, other) => own.is_none() && other.is_none(),
        };
        sizes == [passed.values.len(), passed.exact.len()] && altered
    }

    /// Back to a state.
    pub(crate) fn restore(&mut self, passed: &ExchangeState) {
        self.values.clone_from(&passed.values);
        self.exact.clone_from(&passed.exact);
        self.faults.clone_from(&passed.faults);
    }

    /// All writes at a communication point.
    pub(crate) fn writes(&mut self) -> impl Iterator<Item = &mut Write> {
        self.stages.iter_mut().flat_map(|stage| &mut stage.writes)
    }

    /// Slot in [`Exchange::values`] of a connected output.
    pub fn slot(&self, output: Port) -> Option<usize> {
        self.slots.get(&output).copied()
    }

    /// The connected output with this slot.
    pub fn output(&self, slot: usize) -> Option<Port> {
        let found = self.slots.iter().find(|(_, s)| **s == slot);
        found.map(|(port, _)| *port)
    }

    /// Pass all values, stage by stage.
    pub fn run(&mut self, instances: &[Instance], at: At) -> Result<()> {
        let resting = &self.resting;
        for read in self.first.iter().filter(|r| !rests(resting, r.instance)) {
            read.run_any(instances, &mut self.values, &mut self.exact, at)?;
        }
        self.run_again(instances, at)
    }

    /// Pass all values once more at the same communication point. Outputs that can be read only
    /// once keep their values.
    pub fn run_again(&mut self, instances: &[Instance], at: At) -> Result<()> {
        for k in 0..self.stages.len() {
            self.read_stage(k, instances, at)?;
            match self.stages[k].unknowns.take() {
                None => self.write_stage(k, None, instances, at)?,
                Some(mut unknowns) => {
                    let stage = &mut SolvedStage {
                        exchange: &mut *self,
                        k,
                        instances,
                        at,
                    };
                    let solved = unknowns.solve(stage, at);
                    self.stages[k].unknowns = Some(unknowns);
                    solved?;
                }
            }
        }
        Ok(())
    }

    /// Pass all values until none changes, bit for bit, at most `passes` times. Returns the outputs
    /// that still change. On the way there values need not be finite: in the first pass a component
    /// may divide by an input that it has not got yet.
    pub fn settle(&mut self, instances: &[Instance], at: At, passes: usize) -> Result<Vec<Port>> {
        self.set_preliminary(true);
        let mut changed = Vec::new();
        for _ in 0..passes {
            let (before, exact) = (self.values.clone(), self.exact.clone());
            self.run(instances, at)?;
            let differs = |(_, k): &(&Port, &usize)| {
                before[**k].to_bits() != self.values[**k].to_bits()
                    || exact.get(**k) != self.exact.get(**k)
            };
            let slots = self.slots.iter().filter(differs);
            changed = slots.map(|(port, _)| *port).collect();
            if changed.is_empty() {
                break;
            }
        }
        self.set_preliminary(false);
        if changed.is_empty() {
            self.run(instances, at)?;
        }
        Ok(changed)
    }

    /// Copies the exact values.
    pub(crate) fn copy_exact(&self, to: &mut Vec<Value>) {
        to.resize(self.exact.len(), Value::Whole(0));
        for (to, from) in to.iter_mut().zip(&self.exact) {
            to.clone_from(from);
        }
    }

    /// Whether all values are these, bit for bit.
    pub(crate) fn has_same(&self, values: &[f64], exact: &[Value]) -> bool {
        let mut both = values.iter().zip(&self.values);
        both.all(|(a, b)| a.to_bits() == b.to_bits()) && exact == self.exact
    }

    fn set_preliminary(&mut self, is_preliminary: bool) {
        for stage in &mut self.stages {
            let reads = stage.reads.iter_mut();
            reads.for_each(|read| read.is_preliminary = is_preliminary);
            let writes = stage.writes.iter_mut();
            writes.for_each(|write| write.set_preliminary(is_preliminary));
        }
    }

    /// Read all outputs of one component.
    pub fn read_component(
        &mut self,
        component: usize,
        instances: &[Instance],
        at: At,
    ) -> Result<()> {
        let reads = self.stages.iter().flat_map(|stage| &stage.reads);
        let mut own = reads.filter(|read| read.instance == component);
        own.try_for_each(|read| read.run_any(instances, &mut self.values, &mut self.exact, at))
    }

    /// Set all inputs of one component.
    pub fn write_component(
        &mut self,
        component: usize,
        instances: &[Instance],
        at: At,
    ) -> Result<()> {
        let chosen = Some(component);
        (0..self.stages.len()).try_for_each(|k| self.write_stage(k, chosen, instances, at))
    }

    /// Read the outputs of one component over which clocked values pass.
    pub(crate) fn read_clocked(
        &mut self,
        component: usize,
        all: &[Instance],
        at: At,
    ) -> Result<()> {
        let reads = self.stages.iter().flat_map(|stage| stage.reads.iter());
        let reads = self.first.iter().chain(reads);
        let mut own = reads.filter(|read| read.instance == component && read.is_clocked);
        own.try_for_each(|read| read.run_any(all, &mut self.values, &mut self.exact, at))
    }

    /// Set the inputs of one component over which clocked values pass.
    pub(crate) fn write_clocked(
        &mut self,
        component: usize,
        all: &[Instance],
        at: At,
    ) -> Result<()> {
        let writes = self.stages.iter_mut().flat_map(|stage| &mut stage.writes);
        for write in writes.filter(|write| write.instance == component && write.is_clocked) {
            match write.is_exact {
                true => write.run_exact(all, &self.exact, at)?,
                false => {
                    let faults = self.faults.as_mut();
                    write.run(all, &self.values, faults, at)?;
                }
            }
        }
        Ok(())
    }

    /// Read all outputs.
    pub fn read(&mut self, instances: &[Instance], at: At) -> Result<()> {
        (0..self.stages.len()).try_for_each(|k| self.read_stage(k, instances, at))
    }

    /// Set all inputs to what was last read.
    pub fn write(&mut self, instances: &[Instance], at: At) -> Result<()> {
        (0..self.stages.len()).try_for_each(|k| self.write_stage(k, None, instances, at))
    }

    fn read_stage(&mut self, k: usize, instances: &[Instance], at: At) -> Result<()> {
        if self.is_multi_threaded && self.exact.is_empty() {
            return self.read_in_threads(k, instances, at);
        }
        let (all, resting) = (&self.stages[k].reads, &self.resting);
        let mut reads = all.iter().filter(|read| !rests(resting, read.instance));
        reads.try_for_each(|read| read.run_any(instances, &mut self.values, &mut self.exact, at))
    }

    /// Read a stage; instances in other threads read at the same time.
    fn read_in_threads(&mut self, k: usize, instances: &[Instance], at: At) -> Result<()> {
        let (all, values) = (&self.stages[k].reads, &mut self.values);
        let reads = (all.iter()).filter(|read| !rests(&self.resting, read.instance));
        reads.clone().for_each(|read| read.begin(instances));
        let mut failure = Failure::default();
        for is_elsewhere in [false, true] {
            let there = |read: &&Read| instances[read.instance].is_elsewhere() == is_elsewhere;
            for read in reads.clone().filter(there) {
                failure.add(read.instance, read.run(instances, values, at));
            }
        }
        failure.into()
    }

    /// Set the inputs of a stage, or those of one component.
    fn write_stage(
        &mut self,
        k: usize,
        only: Option<usize>,
        instances: &[Instance],
        at: At,
    ) -> Result<()> {
        let mut faults = self.faults.as_mut();
        // A write to a single component happens between two communication points.
        if let (Some(faults), At::Time(t), None) = (&mut faults, at, only) {
            faults.begin(t);
        }
        if self.is_multi_threaded && self.exact.is_empty() && only.is_none() {
            return self.write_in_threads(k, instances, at);
        }
        for write in &mut self.stages[k].writes {
            if only.is_some_and(|instance| instance != write.instance)
                || rests(&self.resting, write.instance)
            {
                continue;
            }
            if write.is_exact {
                write.run_exact(instances, &self.exact, at)?;
                continue;
            }
            write.run(instances, &self.values, faults.as_deref_mut(), at)?;
        }
        Ok(())
    }

    /// Set the inputs of a stage; instances in other threads do so at the same time. The values are
    /// gathered in order, in which faults draw their random numbers.
    fn write_in_threads(&mut self, k: usize, instances: &[Instance], at: At) -> Result<()> {
        let mut faults = self.faults.as_mut();
        let (writes, resting) = (&mut self.stages[k].writes, &self.resting);
        let (mut failure, mut begun) = (Failure::default(), 0);
        for write in writes.iter_mut().filter(|w| !rests(resting, w.instance)) {
            let done = write.begin(instances, &self.values, faults.as_deref_mut(), at);
            let has_failed = done.is_err();
            failure.add(write.instance, done);
            if has_failed {
                break;
            }
            begun += 1;
        }
        let all = writes.iter().filter(|w| !rests(resting, w.instance));
        for write in all.take(begun) {
            failure.add(write.instance, write.end(instances, at));
        }
        failure.into()
    }

    /// Pass all first time derivatives; [`Exchange::values`] then holds them.
    pub fn run_derivatives(
        &mut self,
        instances: &[Instance],
        faults: Option<&Alteration>,
        at: At,
    ) -> Result<()> {
        for stage in &mut self.stages {
            for read in &stage.reads {
                let values = &mut self.values[read.slots()];
                instances[read.instance].get_derivatives(&read.batch, values, at)?;
            }
            for write in &mut stage.writes {
                write.run_derivatives(instances, &self.values, faults, at)?;
            }
        }
        Ok(())
    }

    /// The stages as text for the user.
    pub fn describe(&self, wiring: &Wiring) -> String {
        let mut text = String::new();
        let count = |n: usize| match n {
            1 => "1 value".to_string(),
            _ => format!("{n} values"),
        };
        let outputs = self.slots.iter().map(|(port, slot)| (*slot, *port));
        let outputs: HashMap<usize, Port> = outputs.collect();
        let name = |slot| outputs.get(&slot).map(|port| wiring.name(*port));
        if !self.first.is_empty() {
            text += "right after the step, before any input is set\n";
        }
        for r in &self.first {
            let names: Vec<_> = r.slots().filter_map(name).collect();
            text += &format!("  get {}, {}\n", count(r.batch.len()), names.join(", "));
        }
        for (k, stage) in self.stages.iter().enumerate() {
            text += &format!("stage {}\n", k + 1);
            for r in &stage.reads {
                let first = name(r.slots.start).unwrap_or_default();
                text += &format!("  get {}, {first} …\n", count(r.batch.len()));
            }
            for w in &stage.writes {
                let component = wiring.component(w.instance);
                text += &format!("  set {} of {component}\n", count(w.batch.len()));
            }
        }
        text
    }
}

/// Whether a component has no communication point now.
fn rests(resting: &[bool], component: usize) -> bool {
    resting.get(component) == Some(&true)
}

/// A stage whose loops are being solved.
struct SolvedStage<'a> {
    exchange: &'a mut Exchange,
    k: usize,
    instances: &'a [Instance],
    at: At,
}

impl LoopStage for SolvedStage<'_> {
    fn values(&mut self) -> &mut [f64] {
        &mut self.exchange.values
    }

    fn write_and_read(&mut self) -> Result<()> {
        let (k, instances, at) = (self.k, self.instances, self.at);
        self.exchange.write_stage(k, None, instances, at)?;
        self.exchange.read_stage(k, instances, at)
    }

    /// The FMUs' derivatives do not know of alterations.
    fn differentiable_instances(&self) -> Option<&[Instance]> {
        self.exchange.faults.is_none().then_some(self.instances)
    }
}
