//! Values that are set and read, and which inputs act on which outputs at once.

use anyhow::Result;
use fmu_description::{Access, Causality, Initial, Variability, Variable};

use super::trial::trials;
use crate::check::outcome::Outcome;
use crate::fmi::Fmu;
use crate::fmi::instance::{Instance, about, references, step_size, told};
use crate::fmi::symbols::{OK, WARNING};

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
        let Some(start) = v.start_of(0).filter(|_| v.size() == 1) else {
            check_array(&instance, v, outcome)?;
            continue;
        };
        let vr = [v.reference];
        let (status, is_equal, value) = match v.access() {
            Access::Real => {
                let (status, values) = instance.reals(&vr);
                let expected = start.trim().parse::<f64>();
                (
                    status,
                    expected.is_ok_and(|e| e == values[0]),
                    values[0].to_string(),
                )
            }
            Access::String => {
                let (status, values) = instance.texts(&vr);
                (status, start == values[0], format!("`{}`", values[0]))
            }
            access => {
                let (status, values) = instance.integers(access, &vr);
                let expected = match start.trim() {
                    "true" => Some(1),
                    "false" => Some(0),
                    number => number.parse().ok(),
                };
                (status, expected == Some(values[0]), values[0].to_string())
            }
        };
        instance.must(
            &format!("reading `{}` in Initialization Mode", v.name),
            status,
        )?;
        if !is_equal {
            outcome.fail(format!(
                "`{}` is {value}, its start value is {start}",
                v.name
            ));
        }
    }
    Ok(())
}

/// The start values of an array of Float64.
fn check_array(instance: &Instance, v: &Variable, outcome: &mut Outcome) -> Result<()> {
    if v.access() != Access::Real || v.start.is_empty() {
        return Ok(());
    }
    for (k, value) in instance.read(v)?.iter().enumerate() {
        let start = v.start_of(k).unwrap_or("nothing");
        if start.parse() != Ok(*value) {
            let number = k + 1;
            outcome.fail(format!(
                "element {number} of `{}` is {value}, its start value is {start}",
                v.name
            ));
        }
    }
    Ok(())
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
    Ok(())
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
