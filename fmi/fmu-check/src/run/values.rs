//! Values that are set and read, and which inputs act on which outputs at once.

use anyhow::Result;
use fmi_description::{Access, Causality, Initial, Variability, Variable};

use super::trial::trials;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, about, references, step_size, told};
use fmi_import::status::{OK, WARNING};

trials! {
    "values" {
        opened starts:
            "parameters and inputs begin at the start values of the description",
            "tools show those to their users, and set only what differs from them";
        opened read_back:
            "an input that is set is read back bit for bit",
            "importers and users check what they have set";
        opened dependencies.unless(without_reading_after_set):
            "an input acts at once only on outputs that list it in their dependencies",
            "importers read outputs before such inputs are set, and then compute with old values";
    }
}

/// Whether a variable begins at its start value, by the standard.
fn is_given(v: &Variable) -> bool {
    let is_set = matches!(v.causality, Causality::Parameter | Causality::Input);
    is_set || v.initial == Some(Initial::Exact) || v.variability == Variability::Constant
}

fn starts(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let instance = Instance::initializing(fmu, "starts")?;
    for v in fmu.description.variables.iter().filter(|v| is_given(v)) {
        if v.start.is_empty() || v.access() == Access::Clock {
            continue;
        }
        let (status, values) = instance.values(v);
        instance.must(
            &format!("reading `{}` in Initialization Mode", v.name),
            status,
        )?;
        for (k, value) in values.iter().enumerate() {
            let start = v.start_of(k).unwrap_or("nothing");
            if !is_same(v.access(), start, value) {
                let element = match v.size() {
                    1 => format!("`{}`", v.name),
                    _ => format!("element {} of `{}`", k + 1, v.name),
                };
                outcome.fail(format!("{element} is {value}, its start value is {start}"));
            }
        }
    }
    Ok(())
}

/// Whether two texts are the same value.
fn is_same(access: Access, a: &str, b: &str) -> bool {
    let (a, b) = (a.trim(), b.trim());
    match access {
        Access::Real => a.parse::<f64>().is_ok_and(|a| b.parse() == Ok(a)),
        Access::Float32 => a.parse::<f32>().is_ok_and(|a| b.parse() == Ok(a)),
        Access::Boolean => [("true", "1"), ("false", "0")].contains(&(b, a)) || a == b,
        Access::String => a == b,
        Access::Binary => a.eq_ignore_ascii_case(b),
        _ => a.parse::<i128>().is_ok_and(|a| b.parse() == Ok(a)),
    }
}

/// Values near the start values, inside the bounds.
fn beside(v: &Variable) -> Option<Vec<f64>> {
    (0..v.size()).map(|k| beside_element(v, k)).collect()
}

fn beside_element(v: &Variable, element: usize) -> Option<f64> {
    let (start, scale) = about(v, element);
    let [min, max] = v.bounds();
    [start + 0.01 * scale, start - 0.01 * scale]
        .into_iter()
        .find(|value| (min..=max).contains(value))
}

fn is_real_input(v: &&Variable) -> bool {
    v.is_input() && v.access() == Access::Real
}

fn read_back(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let instance = Instance::exchanging(fmu, "back")?;
    for v in fmu.description.variables.iter().filter(is_real_input) {
        let Some(value) = beside(v) else {
            continue;
        };
        let status = instance.set_reals(&[v.reference], &value);
        if status > WARNING {
            let reason = told(&instance.messages());
            outcome.remark(format!("`{}` = {value:?} was refused{reason}", v.name));
            continue;
        }
        let back = instance.read(v)?;
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        if bits(&back) != bits(&value) {
            outcome.remark(format!(
                "`{}`: {value:?} was set, {back:?} came back",
                v.name
            ));
        }
    }
    let others = |v: &&Variable| v.is_input() && !is_real_input(v) && v.access() != Access::Clock;
    for v in fmu.description.variables.iter().filter(others) {
        let (status, values) = instance.values(v);
        instance.must(&format!("reading `{}`", v.name), status)?;
        let Some(values) = values
            .iter()
            .map(|value| other(v, value))
            .collect::<Option<Vec<_>>>()
        else {
            continue;
        };
        let status = instance.set_values(v, &values);
        if status > WARNING {
            let reason = told(&instance.messages());
            outcome.remark(format!("`{}` = {values:?} was refused{reason}", v.name));
            continue;
        }
        let (_, back) = instance.values(v);
        if back != values {
            outcome.remark(format!(
                "`{}`: {values:?} was set, {back:?} came back",
                v.name
            ));
        }
    }
    Ok(())
}

/// Another value of an element than it has; None where there is none within its bounds.
fn other(v: &Variable, value: &str) -> Option<String> {
    match v.access() {
        Access::Boolean => Some((value != "true").to_string()),
        Access::String => Some(format!("{value}x")),
        Access::Binary => Some(format!("{value}0a")),
        Access::Float32 => None, // as Float64
        _ => {
            let ([min, max], value) = (v.bounds(), value.parse::<i128>().ok()?);
            let fits = |value: &i128| (min..=max).contains(&(*value as f64));
            [value ^ 1, value + 1]
                .into_iter()
                .find(fits)
                .map(|v| v.to_string())
        }
    }
}

/// What acts at once is seen by reading outputs after an input was set, which not every FMU has to
/// bear.
pub fn without_reading_after_set(fmu: &Fmu) -> Option<&'static str> {
    let reason = "FMI 3.0 lets nothing be read between a set and the next step but in Event Mode, which the FMU does not have";
    (!fmu.functions.reads_after_set()).then_some(reason)
}

fn dependencies(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let description = &fmu.description;
    let is_output = |v: &Variable| v.causality == Causality::Output && v.access() == Access::Real;
    let outputs: Vec<_> = (0..description.variables.len())
        .filter(|k| is_output(&description.variables[*k]))
        .flat_map(|k| vec![k; description.variables[k].size()])
        .collect();
    let vr = references(&description.variables, is_output);
    let mut instance = Instance::started(fmu, "dependencies")?;
    (0..2).try_for_each(|_| instance.step(step_size(fmu)))?;
    let (status, before) = instance.reals(&vr);
    instance.must("fmi2GetReal of all outputs", status)?;
    let mut acting = 0;
    let inputs = description.variables.iter().enumerate();
    for (index, input) in inputs.filter(|(_, v)| is_real_input(v)) {
        let old = instance.read(input)?;
        let Some(value) = beside(input) else {
            continue;
        };
        if !matches!(instance.set_reals(&[input.reference], &value), OK | WARNING) {
            continue;
        }
        let (status, after) = instance.reals(&vr);
        if matches!(status, OK | WARNING) {
            for ((output, before), after) in outputs.iter().zip(&before).zip(&after) {
                let acts = before.to_bits() != after.to_bits();
                acting += usize::from(acts);
                if acts && !description.feedthrough(*output, false).contains(&index) {
                    let output = &description.variables[*output].name;
                    outcome.fail(format!(
                        "`{}` acts on `{output}`, which does not list it",
                        input.name
                    ));
                }
            }
        }
        let status = instance.set_reals(&[input.reference], &old);
        instance.must(&format!("fmi2SetReal of `{}`", input.name), status)?;
    }
    outcome.note(format!("{acting} pairs of input and output act at once"));
    Ok(())
}
