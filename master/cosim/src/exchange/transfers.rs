//! Batched reads and writes: variables of one component and one type that one call of the FMU gets
//! or sets, with the slots of their values. The parts that exchanges are planned from.

use std::collections::BTreeMap;
use std::ops::Range;

use anyhow::Result;

use crate::exchange::faults::Alteration;
use crate::instance::{At, BegunCall, Instance};
use crate::wiring::transformation::Transformation;
use crate::wiring::{Port, Wiring};
use fmi_import::batch::Batch;
use fmi_import::value::Value;

/// Outputs of one component and one type that are read together.
#[derive(Debug)]
pub struct Read {
    pub(super) instance: usize,
    pub(super) batch: Batch,
    pub(super) slots: Range<usize>,
}

impl Read {
    pub fn component(&self) -> usize {
        self.instance
    }

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
        match self.batch.is_wide {
            false => self.run(instances, values, at),
            true => {
                instances[self.instance].get_whole(&self.batch, &mut exact[self.slots.clone()], at)
            }
        }
    }

    /// Read the values into their slots.
    pub fn run(&self, instances: &[Instance], values: &mut [f64], at: At) -> Result<()> {
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
    /// The values are passed exactly, not as f64.
    pub(super) is_exact: bool,
}

impl Write {
    pub fn component(&self) -> usize {
        self.instance
    }

    pub(crate) fn len(&self) -> usize {
        self.slots.len()
    }

    /// From now on alter the values that `faults` concern.
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

    /// Set the inputs to the values in their slots; `buffer` is workspace for all of them.
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

    /// Set the inputs of an instance in this thread, or begin to set those of one in another thread.
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

    /// End what [`Write::begin`] began.
    pub(crate) fn end(&self, instances: &[Instance], at: At) -> Result<()> {
        match instances[self.instance].is_elsewhere() {
            true => instances[self.instance].set(&self.batch, &[], at),
            false => Ok(()),
        }
    }

    /// The values with alterations and transformations.
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
                buffer[*k] = faults.alter(*channel, buffer[*k]);
            }
        };
        alter(&self.altered[0], buffer);
        for (k, transformation) in &self.transformed {
            buffer[*k] = transformation.apply(buffer[*k]);
        }
        alter(&self.altered[1], buffer);
        buffer
    }

    /// Set the inputs to exact values; `buffer` is workspace.
    pub(super) fn run_exact(
        &self,
        instances: &[Instance],
        exact: &[Value],
        buffer: &mut Vec<Value>,
        at: At,
    ) -> Result<()> {
        buffer.clear();
        buffer.extend(self.slots.iter().map(|slot| exact[*slot].clone()));
        for (k, transformation) in &self.transformed {
            if let Value::Whole(number) = &mut buffer[*k] {
                *number = transformation.apply_whole(*number);
            }
        }
        instances[self.instance].set_whole(&self.batch, buffer, at)
    }

    /// The same for time derivatives.
    pub(super) fn gather_derivatives<'a>(
        &self,
        values: &[f64],
        buffer: &'a mut [f64],
        faults: Option<&Alteration>,
    ) -> &'a mut [f64] {
        let buffer = self.gather_raw(values, buffer);
        for (k, transformation) in &self.transformed {
            buffer[*k] = transformation.apply_rate(buffer[*k]);
        }
        if let Some(faults) = faults {
            for (k, channel) in self.altered.iter().flatten() {
                buffer[*k] = faults.alter_rate(*channel, buffer[*k]);
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

/// One read per component, type and clocks. New slots are added to `slots`, contiguous for each read.
pub fn reads(
    wiring: &Wiring,
    ports: impl Iterator<Item = Port>,
    slots: &mut BTreeMap<Port, usize>,
) -> Vec<Read> {
    let mut together: BTreeMap<_, Vec<Port>> = BTreeMap::new();
    for port in ports {
        let key = (
            port.component,
            wiring.access(port),
            &wiring.variable(port).clocks,
        );
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

/// One write per component, type and clocks, of inputs with the slots and transformations of their
/// values.
pub fn writes(
    wiring: &Wiring,
    inputs: impl Iterator<Item = (Port, usize, Transformation)>,
) -> Vec<Write> {
    let mut together: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for input in inputs {
        let port = input.0;
        let key = (
            port.component,
            wiring.access(port),
            &wiring.variable(port).clocks,
        );
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
            is_exact: false,
        });
    }
    writes
}
