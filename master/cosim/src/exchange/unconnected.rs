//! Watches outputs that no connection passes on, for the verdict: one that is not finite spoils the
//! result, but not the run. `coupling` reads them right after each step, before inputs are set.
//!
//! FMUs of the kit (`fmu-export`) refuse to hand out such a number themselves, which ends the run.
//! Theirs are therefore read at some communication points only, at next to no cost.

use std::collections::BTreeMap;

use anyhow::Result;
use fmi_description::{Access, Causality};

use crate::exchange::{Exchange, Read, reads, rests};
use crate::instance::finite::are_finite;
use crate::instance::{At, Failure, Instance};
use crate::wiring::{Port, Wiring};

/// Outputs of the kit's FMUs are read at as many first communication points,
const FIRST: u32 = 64;
/// then at each whose number is a multiple of this.
const SELDOM: u32 = 1024;

/// Reads of the outputs, with their values.
pub(crate) struct Unconnected {
    reads: Vec<UnconnectedRead>,
    values: Vec<f64>,
    ports: Vec<Port>,
    /// By slot of the values: the time, s, at which one was first not finite, and the value then.
    pub found: Vec<Option<[f64; 2]>>,
    /// Why some are no longer read.
    pub remarks: Vec<String>,
    points: u32,
}

struct UnconnectedRead {
    read: Read,
    is_from_kit: bool,
    /// Reading failed once.
    has_failed: bool,
}

impl Unconnected {
    /// The outputs of a system that `exchange` does not pass on, except those that may have any
    /// value.
    pub fn new(wiring: &Wiring, exchange: &Exchange, instances: &[Instance]) -> Self {
        let mut ports = Vec::new();
        for (component, instance) in instances.iter().enumerate() {
            let all = wiring.description(component).variables.iter().enumerate();
            for (variable, v) in all.filter(|(_, v)| v.causality == Causality::Output) {
                let port = Port::new(component, variable);
                let is_real = matches!(v.access(), Access::Real | Access::Float32);
                let is_passed = exchange.slot(port).is_some();
                if is_real && !is_passed && !instance.may_be_nonfinite(variable) {
                    ports.push(port);
                }
            }
        }
        let mut slots = BTreeMap::new();
        let planned = reads(wiring, ports.into_iter(), &mut slots);
        let tool = |read: &Read| &wiring.description(read.instance).tool;
        let reads = planned.into_iter().map(|read| UnconnectedRead {
            is_from_kit: tool(&read).starts_with("fmu-export "),
            read,
            has_failed: false,
        });
        let mut by_slot: Vec<_> = slots.into_iter().map(|(port, slot)| (slot, port)).collect();
        by_slot.sort_unstable();
        Self {
            reads: reads.collect(),
            values: vec![0.0; by_slot.len()],
            found: vec![None; by_slot.len()],
            ports: by_slot.into_iter().map(|(_, port)| port).collect(),
            remarks: Vec::new(),
            points: 0,
        }
    }

    /// The outputs that were not finite, each with the time and the value.
    pub fn nonfinite(&self) -> impl Iterator<Item = (Port, [f64; 2])> {
        let all = self.ports.iter().zip(&self.found);
        all.filter_map(|(port, found)| Some((*port, (*found)?)))
    }

    /// Read the outputs at `t`, s, of the components that have a communication point now. An FMU
    /// that does not let an output be read goes on without: nothing needs the value.
    pub fn read(&mut self, instances: &[Instance], resting: &[bool], t: f64) -> Result<()> {
        let has_all = self.points < FIRST || self.points.is_multiple_of(SELDOM);
        self.points = self.points.wrapping_add(1);
        let is_read = |one: &UnconnectedRead| {
            !one.has_failed && (has_all || !one.is_from_kit) && !rests(resting, one.read.instance)
        };
        for one in self.reads.iter().filter(|one| is_read(one)) {
            one.read.begin(instances);
        }
        let (mut failure, at) = (Failure::default(), At::Time(t));
        for one in self.reads.iter_mut().filter(|one| is_read(one)) {
            let done = one.read.run_unchecked(instances, &mut self.values, at);
            match done {
                Err(error) if one.is_from_kit => failure.add(one.read.instance, Err(error)),
                Err(error) => {
                    one.has_failed = true;
                    self.remarks.push(format!(
                        "outputs that cannot be read are not watched: {error:#}"
                    ));
                }
                Ok(()) if are_finite(&self.values[one.read.slots()]) => {}
                Ok(()) => {
                    for slot in one.read.slots() {
                        let value = self.values[slot];
                        if !value.is_finite() {
                            self.found[slot].get_or_insert([t, value]);
                        }
                    }
                }
            }
        }
        failure.into()
    }
}
