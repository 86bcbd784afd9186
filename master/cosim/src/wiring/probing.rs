//! Finds direct feedthrough by experiment: changes each input of an FMU in Initialization Mode and
//! looks which outputs change. `cosim wiring --try` prints the result as a hint, because a
//! dependency may show only at other values; no run uses it.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use fmi_description::{Causality, Kind, Variable};

use crate::instance::{At, Instance};
use crate::io::numbers::fits;
use crate::run::instances::instantiate;
use crate::structure::system::System;

/// Feedthrough found in a component; variables are indices in its description.
#[derive(Debug, Default)]
pub struct FoundFeedthrough {
    /// For each output the inputs that change it.
    pub acting: BTreeMap<usize, BTreeSet<usize>>,
    /// Inputs of which the FMU refuses other values.
    pub refused: BTreeSet<usize>,
}

/// Change each input of the component with the index `k` by itself and note which outputs change:
/// from the start values, then from values moved away from them, where products with zero show,
/// too.
pub fn probe(system: &System, k: usize) -> Result<FoundFeedthrough> {
    let variables = &system.fmus[k].description.variables;
    let numbers = |is_taken: fn(&Variable) -> bool| -> Vec<usize> {
        let all = (0..variables.len()).filter(|k| variables[*k].access().is_number());
        all.filter(|k| is_taken(&variables[*k])).collect()
    };
    let inputs = numbers(Variable::is_input);
    let outputs = numbers(|v| v.causality == Causality::Output);
    let mut found = FoundFeedthrough::default();
    for is_moved in [false, true] {
        // After an error an instance cannot be used: the next input gets another one.
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

/// An instance in Initialization Mode at its start values; or with Reals moved away from them, if
/// the FMU accepts that.
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
        // Each input is moved by a different share.
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

/// Values on both sides of `value` that a variable accepts.
fn others(v: &Variable, value: f64) -> impl Iterator<Item = f64> {
    let by = match v.kind {
        Kind::Real => 0.1 * scale(v, value),
        _ => 1.0,
    };
    let both = [value + by, value - by].into_iter();
    both.filter(|other| fits(v, *other))
}
