//! Batched reads and writes: variables of one component, type and clocks that one call of the FMU
//! gets or sets, with the slots of their values. Exchanges, signals and input tables use them.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

use anyhow::Result;
use fmi_description::Access;

use crate::exchange::faults::Alteration;
use crate::instance::{At, BegunCall, Instance};
use crate::wiring::transformation::Transformation;
use crate::wiring::{Port, Wiring};
use fmi_import::batch::Batch;
use fmi_import::value::Value;

/// Outputs of one component and one type that are read together.
#[derive(Clone, Debug)]
pub struct Read {
    pub(super) instance: usize,
    pub(super) batch: Batch,
    pub(super) slots: Range<usize>,
    /// The values may not be final yet, and are not checked.
    pub(super) is_preliminary: bool,
    /// Some pass to or from a clocked variable.
    pub(super) is_clocked: bool,
}

impl Read {
    pub(crate) fn slots(&self) -> Range<usize> {
        self.slots.clone()
    }

    /// Begin the read of an instance in another thread.
    pub(crate) fn begin(&self, instances: &[Instance]) {
        instances[self.instance].begin(BegunCall::Get(&self.batch));
    }

    /// Read the values into their slots, as f64 or exactly.
    pub(super) fn run_any(
        &self,
        instances: &[Instance],
        values: &mut [f64],
        exact: &mut [Value],
        at: At,
    ) -> Result<()> {
        match self.batch.is_non_numeric {
            false => self.run(instances, values, at),
            true => {
                instances[self.instance].get_whole(&self.batch, &mut exact[self.slots.clone()], at)
            }
        }
    }

    /// Read the values into their slots; they must be finite.
    pub fn run(&self, instances: &[Instance], values: &mut [f64], at: At) -> Result<()> {
        if self.is_preliminary {
            return self.run_unchecked(instances, values, at);
        }
        instances[self.instance].get_finite(&self.batch, &mut values[self.slots.clone()], at)
    }

    /// The same for values that are looked at only.
    pub fn run_unchecked(&self, instances: &[Instance], values: &mut [f64], at: At) -> Result<()> {
        instances[self.instance].get(&self.batch, &mut values[self.slots.clone()], at)
    }
}

/// Inputs of one component and one type that are set together.
#[derive(Debug)]
pub struct Write {
    pub(super) instance: usize,
    pub(super) batch: Batch,
    slots: Vec<usize>,
    /// Transformations, by place of the value in the batch.
    transformed: Vec<(usize, Transformation)>,
    /// Altered values, by place and channel: alterations at the outputs, and at the inputs.
    altered: [Vec<(usize, usize)>; 2],
    /// What is added to values that are sums.
    terms: Vec<Term>,
    /// The values are passed exactly, not as f64.
    pub(super) is_exact: bool,
    /// Some pass to or from a clocked variable.
    pub(super) is_clocked: bool,
    /// The values are those that a [`Read`] has found to be finite.
    is_checked: bool,
    buffer: Vec<f64>,
    exact_buffer: Vec<Value>,
}

/// A further value of an input that is a sum.
#[derive(Debug)]
struct Term {
    /// Place of the sum in the batch.
    place: usize,
    slot: usize,
    transformation: Transformation,
    /// Channel of the alteration at the output.
    altered: Option<usize>,
}

impl Write {
    /// From now on alter the values that `faults` concern, and no others.
    pub fn attach(&mut self, wiring: &Wiring, faults: &mut Alteration) {
        self.altered.iter_mut().for_each(Vec::clear);
        for (place, variable) in self.batch.variables.iter().enumerate() {
            let input = Port::new(self.instance, *variable);
            let ends = [wiring.source(input), Some(input)];
            for (port, altered) in ends.iter().zip(&mut self.altered) {
                let channel = port.and_then(|port| faults.channel(port));
                altered.extend(channel.map(|channel| (place, channel)));
            }
            let own = self.terms.iter_mut().filter(|term| term.place == place);
            for (term, link) in own.zip(wiring.terms(input).skip(1)) {
                term.altered = faults.channel(link.from);
            }
        }
        self.is_checked &= self.altered.iter().all(Vec::is_empty);
    }

    /// The values may not be final yet, and are not checked.
    pub(super) fn set_preliminary(&mut self, is_preliminary: bool) {
        self.is_checked = is_preliminary;
    }

    /// Promises that all values come from a [`Read`]: those that nothing changes on their way need
    /// no further check.
    pub fn trust_sources(&mut self) {
        let is_passed_on = self.transformed.is_empty() && self.terms.is_empty();
        self.is_checked = is_passed_on && self.batch.access == Access::Real;
    }

    /// Set the inputs to the values in their slots.
    pub fn run(
        &mut self,
        instances: &[Instance],
        values: &[f64],
        faults: Option<&mut Alteration>,
        at: At,
    ) -> Result<()> {
        self.gathered(instances, values, faults, at)?;
        self.set(instances, at)
    }

    /// Set the inputs to what was gathered.
    pub(super) fn set(&self, instances: &[Instance], at: At) -> Result<()> {
        instances[self.instance].set(&self.batch, &self.buffer, at)
    }

    /// Gather the values, which must be finite.
    pub(super) fn gathered(
        &mut self,
        instances: &[Instance],
        values: &[f64],
        faults: Option<&mut Alteration>,
        at: At,
    ) -> Result<&[f64]> {
        self.gather(values, faults);
        if !self.is_checked {
            instances[self.instance].check_given(&self.batch, &self.buffer, at)?;
        }
        Ok(&self.buffer)
    }

    /// Set the inputs of an instance in this thread, or begin to set those of one in another
    /// thread.
    pub fn begin(
        &mut self,
        instances: &[Instance],
        values: &[f64],
        faults: Option<&mut Alteration>,
        at: At,
    ) -> Result<()> {
        let instance = &instances[self.instance];
        if !instance.is_elsewhere() {
            return self.run(instances, values, faults, at);
        }
        self.gathered(instances, values, faults, at)?;
        instance.begin(BegunCall::Set(&self.batch, &self.buffer));
        Ok(())
    }

    /// End what [`Write::begin`] began.
    pub fn end(&self, instances: &[Instance], at: At) -> Result<()> {
        match instances[self.instance].is_elsewhere() {
            true => instances[self.instance].set(&self.batch, &[], at),
            false => Ok(()),
        }
    }

    /// Gather the values, with alterations and transformations.
    fn gather(&mut self, values: &[f64], mut faults: Option<&mut Alteration>) {
        self.gather_raw(values);
        let buffer = &mut self.buffer;
        let mut alter = |altered: &[(usize, usize)], buffer: &mut [f64]| {
            let Some(faults) = &mut faults else { return };
            for (k, channel) in altered {
                buffer[*k] = faults.alter(*channel, buffer[*k]);
            }
        };
        alter(&self.altered[0], buffer);
        for (k, transformation) in &self.transformed {
            buffer[*k] = transformation.apply(buffer[*k]);
        }
        for term in &self.terms {
            let mut value = [values[term.slot]];
            if let Some(channel) = term.altered {
                alter(&[(0, channel)], &mut value);
            }
            buffer[term.place] += term.transformation.apply(value[0]);
        }
        alter(&self.altered[1], buffer);
    }

    fn gather_raw(&mut self, values: &[f64]) {
        for (b, slot) in self.buffer.iter_mut().zip(&self.slots) {
            *b = values[*slot];
        }
    }

    /// Set the inputs to exact values.
    pub fn run_exact(&mut self, instances: &[Instance], values: &[Value], at: At) -> Result<()> {
        let buffer = &mut self.exact_buffer;
        buffer.resize(self.slots.len(), Value::Whole(0));
        for (own, slot) in buffer.iter_mut().zip(&self.slots) {
            own.clone_from(&values[*slot]);
        }
        for (k, transformation) in &self.transformed {
            if let Value::Whole(number) = &mut buffer[*k] {
                *number = transformation.apply_whole(*number);
            }
        }
        instances[self.instance].set_whole(&self.batch, buffer, at)
    }

    /// Set the first time derivatives of the inputs.
    pub fn run_derivatives(
        &mut self,
        instances: &[Instance],
        rates: &[f64],
        faults: Option<&Alteration>,
        at: At,
    ) -> Result<()> {
        self.gather_raw(rates);
        let buffer = &mut self.buffer;
        for (k, transformation) in &self.transformed {
            buffer[*k] = transformation.apply_rate(buffer[*k]);
        }
        for term in &self.terms {
            let rate = match (faults, term.altered) {
                (Some(faults), Some(channel)) => faults.alter_rate(channel, rates[term.slot]),
                _ => rates[term.slot],
            };
            buffer[term.place] += term.transformation.apply_rate(rate);
        }
        if let Some(faults) = faults {
            for (k, channel) in self.altered.iter().flatten() {
                buffer[*k] = faults.alter_rate(*channel, buffer[*k]);
            }
        }
        instances[self.instance].set_derivatives(&self.batch, buffer, at)
    }
}

/// Variables of the same component, type and clocks pass in one call.
fn call_key(wiring: &Wiring, port: Port) -> (usize, Access, Vec<u32>) {
    let v = wiring.variable(port);
    (port.component, v.access(), v.clocks.clone())
}

/// One read per component, type and clocks. New slots are added to `slots`, contiguous for each
/// read.
pub fn reads(
    wiring: &Wiring,
    ports: impl Iterator<Item = Port>,
    slots: &mut BTreeMap<Port, usize>,
) -> Vec<Read> {
    let mut together: BTreeMap<_, Vec<Port>> = BTreeMap::new();
    let mut seen = HashSet::new();
    for port in ports.filter(|port| seen.insert(*port)) {
        let list = together.entry(call_key(wiring, port)).or_default();
        list.push(port);
    }
    let mut reads = Vec::new();
    for ((instance, ..), ports) in together {
        let start = slots.len();
        for (k, port) in ports.iter().enumerate() {
            slots.insert(*port, start + k);
        }
        reads.push(Read {
            instance,
            batch: wiring.batch(instance, ports.iter().map(|p| p.variable)),
            slots: start..start + ports.len(),
            is_preliminary: false,
            is_clocked: ports.iter().any(|port| wiring.passes_at_ticks(*port)),
        });
    }
    reads
}

/// One write per component, type and clocks, of inputs with the slots and transformations of their
/// values. What has an input several times becomes their sum.
pub fn writes(
    wiring: &Wiring,
    inputs: impl Iterator<Item = (Port, usize, Transformation)>,
) -> Vec<Write> {
    let mut together: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for input in inputs {
        let key = call_key(wiring, input.0);
        together.entry(key).or_default().push(input);
    }
    let mut writes = Vec::new();
    for ((instance, ..), all) in together {
        let (mut places, mut inputs, mut terms) = (HashMap::new(), Vec::new(), Vec::new());
        for (port, slot, transformation) in all {
            let place = *places.entry(port).or_insert(inputs.len());
            match place == inputs.len() {
                true => inputs.push((port, slot, transformation)),
                false => terms.push(Term {
                    place,
                    slot,
                    transformation,
                    altered: None,
                }),
            }
        }
        let transformed = inputs.iter().map(|(.., t)| t.clone()).enumerate();
        let transformed = transformed.filter(|(_, t)| *t != Transformation::NONE);
        writes.push(Write {
            instance,
            batch: wiring.batch(instance, inputs.iter().map(|(port, ..)| port.variable)),
            slots: inputs.iter().map(|(_, slot, _)| *slot).collect(),
            transformed: transformed.collect(),
            altered: Default::default(),
            terms,
            is_exact: false,
            is_clocked: inputs
                .iter()
                .any(|(port, ..)| wiring.passes_at_ticks(*port)),
            is_checked: false,
            buffer: vec![0.0; inputs.len()],
            exact_buffer: Vec::new(),
        });
    }
    writes
}
