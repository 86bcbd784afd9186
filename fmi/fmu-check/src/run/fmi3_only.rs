//! Probes of FMI 3.0 only, for `supervision`: how steps ended, numbers of values, dependencies.

use anyhow::{Context, Result, bail};
use fmi_description::{Access, Causality, Variable, Version};

use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, references, step_size};
use fmi_import::raw::{Array, StepEnd};
use fmi_import::status::WARNING;

probes! {
    "simulation" {
        opened step_end.only_in(Version::Fmi3):
            "a step tells how it ended: not early where that was not allowed, and at its last successful time",
            "importers go on from there [FMI 3.0, 4.2.1.1]";
    }
    "misuse" {
        opened counts.only_in(Version::Fmi3):
            "a number of values that does not fit the variables is refused",
            "an importer that takes an array for a scalar reads or writes foreign memory";
    }
    "derivatives" {
        opened variable_dependencies.only_in(Version::Fmi3).if_claimed(|c| c.element_dependencies):
            "dependencies of elements are those of ModelStructure, if providesPerElementDependencies",
            "importers sort by the latter and differentiate by the former [FMI 3.0, 2.2.9]";
    }
}

fn step_end(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let h = step_size(fmu);
    let mut instance = Instance::started(fmu, "step end")?;
    instance.enter_step_mode()?;
    for k in 0..10 {
        let (t, mut end) = (instance.time, StepEnd::default());
        end.time = f64::NAN;
        let status = instance.do_step(t, h, 1, &mut end);
        instance.must(&format!("fmi3DoStep from {t} s by {h} s"), status)?;
        if end.early {
            bail!("step {k} returned early, which it was not allowed to");
        }
        let last = end.time;
        if (last - (t + h)).abs().is_nan() || (last - (t + h)).abs() > 1e-6 * h {
            outcome.fail(format!(
                "after the step to {} s lastSuccessfulTime is {last} s",
                t + h
            ));
            return Ok(());
        }
        instance.time += h;
        if end.event_needed || end.terminates {
            break;
        }
    }
    Ok(())
}

fn counts(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let instance = Instance::readable_after_set(fmu, "counts")?;
    let is_input = |v: &&Variable| v.is_input() && v.access() == Access::Real;
    let mut calls = 0;
    for v in fmu.description.variables.iter().filter(is_input) {
        let values = instance.read(v)?;
        let n = values.len();
        // One value more than there are elements.
        let mut numbers = vec![0; n + 1];
        for (to, value) in numbers
            .iter_mut()
            .zip(values.iter().chain(&values[n - 1..]))
        {
            *to = value.to_bits();
        }
        for wrong in [n - 1, n + 1] {
            let vr = Array::Elements(std::slice::from_ref(&v.reference));
            let got = instance.get_numbers(Access::Real, vr, Some(&mut numbers), wrong);
            let set = instance.set_numbers(Access::Real, vr, Array::Elements(&numbers), wrong);
            calls += 2;
            for (call, status) in [("fmi3GetFloat64", got), ("fmi3SetFloat64", set)] {
                if status <= WARNING {
                    outcome.remark(format!(
                        "{call} of `{}` with nValues = {wrong} was accepted",
                        v.name
                    ));
                }
            }
        }
    }
    instance.messages();
    match calls {
        0 => outcome.not_checked = Some("there is no variable to try it with".into()),
        calls => outcome.note(format!("{calls} calls")),
    }
    Ok(())
}

fn variable_dependencies(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let description = &fmu.description;
    let instance = Instance::started(fmu, "dependencies")?;
    let is_output = |v: &Variable| v.causality == Causality::Output;
    for reference in references(&description.variables, is_output) {
        let mut n = 0;
        let status = instance.count_dependencies(reference, Some(&mut n));
        let output = fmu.find(reference).context("a variable has gone")?;
        let name = &output.name;
        instance.must(
            &format!("fmi3GetNumberOfVariableDependencies of `{name}`"),
            status,
        )?;
        if n == 0 {
            continue;
        }
        let (status, of, on) = instance.get_dependencies(reference, n);
        instance.must(&format!("fmi3GetVariableDependencies of `{name}`"), status)?;
        // Elements count from 1, and 0 stands for all of them (FMI 3.0.2, section 2.2.10).
        if let Some(element) = of.iter().find(|element| **element > output.size()) {
            outcome.fail(format!("`{name}` has no element {element}"));
        }
        let of = |k: usize| description.variables[k].reference;
        let mut entries = description.outputs.iter();
        let entry = entries.find(|unknown| of(unknown.variable) == reference);
        let Some(listed) = entry.and_then(|unknown| unknown.dependencies.as_ref()) else {
            continue; // it depends on everything
        };
        let is_listed = |on: &u32| listed.iter().any(|k| of(*k) == *on);
        if let Some(other) = on.iter().find(|on| !is_listed(on)) {
            outcome.fail(format!(
                "`{name}` depends on {other}, which its entry does not list"
            ));
        }
    }
    Ok(())
}
