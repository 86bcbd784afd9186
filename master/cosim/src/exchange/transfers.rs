//! What one component's variables of one type pass in one call: read together, or set together.

use std::collections::BTreeMap;
use std::ops::Range;

use anyhow::Result;

use crate::exchange::faults::Alteration;
use crate::instance::{At, BegunCall, Instance};
use crate::wiring::transformation::Transformation;
use crate::wiring::{Port, Wiring};
use fmi_import::batch::Batch;
use fmi_import::value::Value;

/// Values of one component's variables of one type, read together.
#[derive(Debug)]
pub struct Read {
    pub(super) instance: usize,
    pub(super) batch: Batch,
    pub(super) slots: Range<usize>,
}

impl Read {
    /// Component that is read.
    pub fn component(&self) -> usize {
        self.instance
    }

    /// Slots of the values.
    pub(crate) fn slots(&self) -> Range<usize> {
        self.slots.clone()
    }

    /// Begin to read where the instance is in another thread.
    pub(crate) fn begin(&self, instances: &[Instance]) {
        instances[self.instance].begin(BegunCall::Get(&self.batch));
    }

    pub(super) fn run_any(
        &self,
        instances: &[Instance],
        values: &mut [f64],
        wide: &mut [Value],
        at: At,
    ) -> Result<()> {
        match self.batch.is_non_numeric {
            false => self.run(instances, values, at),
            true => {
                instances[self.instance].get_whole(&self.batch, &mut wide[self.slots.clone()], at)
            }
        }
    }

    /// Read the values into their slots.
    pub fn run(&self, instances: &[Instance], values: &mut [f64], at: At) -> Result<()> {
        instances[self.instance].get(&self.batch, &mut values[self.slots.clone()], at)
    }
}

/// Values of one component's inputs of one type, set together.
#[derive(Debug)]
pub struct Write {
    pub(super) instance: usize,
    pub(super) batch: Batch,
    slots: Vec<usize>,
    /// What becomes of some of the values on their way, by place.
    transformed: Vec<(usize, Transformation)>,
    /// Which values are altered, by place and channel: as outputs give them, and as inputs take
    /// them.
    altered: [Vec<(usize, usize)>; 2],
    /// The values come from outputs that do not pass as numbers.
    pub(super) is_wide: bool,
}

impl Write {
    /// Component that is written to.
    pub fn component(&self) -> usize {
        self.instance
    }

    /// Number of values.
    pub(crate) fn len(&self) -> usize {
        self.slots.len()
    }

    /// From now on values are altered on their way.
    pub(crate) fn attach(&mut self, wiring: &Wiring, faults: &mut Alteration) {
        for (place, variable) in self.batch.variables.iter().enumerate() {
            let input = Port {
                component: self.instance,
                variable: *variable,
            };
            let ends = [wiring.source(input), Some(input)];
            for (port, altered) in ends.iter().zip(&mut self.altered) {
                let channel = port.and_then(|port| faults.channel(port));
                altered.extend(channel.map(|channel| (place, channel)));
            }
        }
    }

    /// Set the inputs to the values in their slots; `buffer` has room for all of them.
    pub fn run(
        &self,
        instances: &[Instance],
        values: &[f64],
        buffer: &mut [f64],
        faults: Option<&mut Alteration>,
        at: At,
    ) -> Result<()> {
        let buffer = self.gather(values, buffer, faults);
        instances[self.instance].set(&self.batch, buffer, at)
    }

    /// Set the inputs of an instance in this thread; of one in another, begin to.
    pub(crate) fn begin(
        &self,
        instances: &[Instance],
        values: &[f64],
        buffer: &mut [f64],
        faults: Option<&mut Alteration>,
        at: At,
    ) -> Result<()> {
        let instance = &instances[self.instance];
        if !instance.is_elsewhere() {
            return self.run(instances, values, buffer, faults, at);
        }
        let buffer = self.gather(values, buffer, faults);
        instance.begin(BegunCall::Set(&self.batch, buffer));
        Ok(())
    }

    /// The end of what was begun.
    pub(crate) fn end(&self, instances: &[Instance], at: At) -> Result<()> {
        match instances[self.instance].is_elsewhere() {
            true => instances[self.instance].set(&self.batch, &[], at),
            false => Ok(()),
        }
    }

    fn gather<'a>(
        &self,
        values: &[f64],
        buffer: &'a mut [f64],
        mut faults: Option<&mut Alteration>,
    ) -> &'a mut [f64] {
        let buffer = self.gather_raw(values, buffer);
        let mut alter = |altered: &[(usize, usize)], buffer: &mut [f64]| {
            let Some(faults) = &mut faults else { return };
            for (k, channel) in altered {
                buffer[*k] = faults.of(*channel, buffer[*k]);
            }
        };
        alter(&self.altered[0], buffer);
        for (k, transformation) in &self.transformed {
            buffer[*k] = transformation.of(buffer[*k]);
        }
        alter(&self.altered[1], buffer);
        buffer
    }

    /// Set the inputs to whole values, which `buffer` takes up.
    pub(super) fn run_wide(
        &self,
        instances: &[Instance],
        wide: &[Value],
        buffer: &mut Vec<Value>,
        at: At,
    ) -> Result<()> {
        buffer.clear();
        buffer.extend(self.slots.iter().map(|slot| wide[*slot].clone()));
        for (k, transformation) in &self.transformed {
            if let Value::Whole(number) = &mut buffer[*k] {
                *number = transformation.of_whole(*number);
            }
        }
        instances[self.instance].set_whole(&self.batch, buffer, at)
    }

    /// Of time derivatives: an offset has none.
    pub(super) fn gather_derivatives<'a>(
        &self,
        values: &[f64],
        buffer: &'a mut [f64],
        faults: Option<&Alteration>,
    ) -> &'a mut [f64] {
        let buffer = self.gather_raw(values, buffer);
        for (k, transformation) in &self.transformed {
            buffer[*k] = transformation.of_derivative(buffer[*k]);
        }
        if let Some(faults) = faults {
            for (k, channel) in self.altered.iter().flatten() {
                buffer[*k] = faults.of_derivative(*channel, buffer[*k]);
            }
        }
        buffer
    }

    fn gather_raw<'a>(&self, values: &[f64], buffer: &'a mut [f64]) -> &'a mut [f64] {
        let buffer = &mut buffer[..self.slots.len()];
        for (b, slot) in buffer.iter_mut().zip(&self.slots) {
            *b = values[*slot];
        }
        buffer
    }
}

/// One read per component, type and clocks; new slots are numbered on in `slots` so that each read fills a
/// contiguous range.
pub fn reads(
    wiring: &Wiring,
    ports: impl Iterator<Item = Port>,
    slots: &mut BTreeMap<Port, usize>,
) -> Vec<Read> {
    let mut together: BTreeMap<_, Vec<Port>> = BTreeMap::new();
    for port in ports {
        let key = (port.component, wiring.access(port), wiring.clocks(port));
        let list = together.entry(key).or_default();
        if !list.contains(&port) {
            list.push(port);
        }
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
        });
    }
    reads
}

/// One write per component, type and clocks, of inputs, the slots their values come from, and what becomes
/// of them on the way.
pub fn writes(
    wiring: &Wiring,
    inputs: impl Iterator<Item = (Port, usize, Transformation)>,
) -> Vec<Write> {
    let mut together: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for input in inputs {
        let port = input.0;
        let key = (port.component, wiring.access(port), wiring.clocks(port));
        together.entry(key).or_default().push(input);
    }
    let mut writes = Vec::new();
    for ((instance, ..), inputs) in together {
        let transformed = inputs.iter().map(|(.., t)| t.clone()).enumerate();
        writes.push(Write {
            instance,
            batch: wiring.batch(instance, inputs.iter().map(|(port, ..)| port.variable)),
            slots: inputs.iter().map(|(_, slot, _)| *slot).collect(),
            transformed: transformed
                .filter(|(_, t)| *t != Transformation::NONE)
                .collect(),
            altered: Default::default(),
            is_wide: false,
        });
    }
    writes
}
