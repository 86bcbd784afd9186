//! Which inputs act at once on which outputs, found by trying in Initialization Mode. A hint: what
//! shows at two points may hide elsewhere. No run uses it.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use fmi_description::{Causality, Kind, Variable};

use crate::instance::{At, Instance};
use crate::io::numbers::fits;
use crate::run::instances::instantiate;
use crate::structure::system::System;

/// What was found of a component; variables are indices in its description.
#[derive(Debug, Default)]
pub struct Found {
    /// Inputs that change an output at once.
    pub acting: BTreeMap<usize, BTreeSet<usize>>,
    /// Inputs whose other values the FMU refuses.
    pub refused: BTreeSet<usize>,
}

/// Change each input of the component with the index `k` by itself, from its start value and from
/// another point, at which products with zero show too, and see which outputs change.
///
/// # Errors
/// The FMU cannot be instantiated or read.
pub fn probe(system: &System, k: usize) -> Result<Found> {
    let variables = &system.fmus[k].description.variables;
    let numbers = |is_taken: fn(&Variable) -> bool| -> Vec<usize> {
        let all = (0..variables.len()).filter(|k| variables[*k].access().is_number());
        all.filter(|k| is_taken(&variables[*k])).collect()
    };
    let inputs = numbers(Variable::is_input);
    let outputs = numbers(|v| v.causality == Causality::Output);
    let mut found = Found::default();
    for is_moved in [false, true] {
        // After an error an instance is good for nothing: the next input gets another one.
        let mut kept = None;
        for input in &inputs {
            let instance = match kept.take() {
                Some(instance) => instance,
                None => at_point(system, k, &inputs, is_moved)?,
            };
            let read = || -> Result<Vec<u64>> {
                // -0 is 0.
                let value =
                    |o: &usize| Ok((instance.number(*o, At::Initialization)? + 0.0).to_bits());
                outputs.iter().map(value).collect()
            };
            let (start, before) = (instance.number(*input, At::Initialization)?, read()?);
            let mut try_all = || -> Result<()> {
                for other in others(&variables[*input], start) {
                    set(&instance, *input, other)?;
                    for (output, (a, b)) in outputs.iter().zip(before.iter().zip(read()?)) {
                        if *a != b {
                            found.acting.entry(*output).or_default().insert(*input);
                        }
                    }
                }
                set(&instance, *input, start)
            };
            match try_all() {
                Ok(()) => kept = Some(instance),
                Err(_) => drop(found.refused.insert(*input)),
            }
        }
    }
    Ok(found)
}

fn set(instance: &Instance, input: usize, value: f64) -> Result<()> {
    let batch = instance.fmu().batch(vec![input])?;
    instance.set(&batch, &[value], At::Initialization)
}

/// An instance in Initialization Mode at its start values; or with Reals moved away from them,
/// where the FMU takes that.
fn at_point(system: &System, k: usize, inputs: &[usize], is_moved: bool) -> Result<Instance> {
    let variables = &system.fmus[k].description.variables;
    let new = || -> Result<Instance> {
        let instance = instantiate(system, k, &[])?;
        instance.enter_initialization(system.structure.start_time)?;
        Ok(instance)
    };
    let instance = new()?;
    for (place, input) in inputs.iter().enumerate().filter(|_| is_moved) {
        let v = &variables[*input];
        let start = instance.number(*input, At::Initialization)?;
        // No two inputs are moved alike.
        let share = 0.1 + 0.05 * (place as f64).sin();
        let moved = start + share * scale(v, start);
        if v.kind == Kind::Real && fits(v, moved) && set(&instance, *input, moved).is_err() {
            drop(instance);
            return new();
        }
    }
    Ok(instance)
}

fn scale(v: &Variable, value: f64) -> f64 {
    value.abs().max(v.nominal.unwrap_or(1.0).abs())
}

/// Values beside `value` that a variable may have.
fn others(v: &Variable, value: f64) -> impl Iterator<Item = f64> {
    let by = match v.kind {
        Kind::Real => 0.1 * scale(v, value),
        _ => 1.0,
    };
    let both = [value + by, value - by].into_iter();
    both.filter(|other| fits(v, *other))
}
