//! Probes of values set and read, and of outputs that inputs act on at once, for `supervision`.

use anyhow::Result;
use fmi_description::{Access, Causality, Initial, Variability, Variable};

use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, last_message, references, start_and_scale, step_size};
use fmi_import::status::{OK, WARNING};

probes! {
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

/// Whether a variable must hold its start value in Initialization Mode.
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

/// Whether two texts are the same value of a type.
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

/// Values of a Real near its start values, within its bounds.
fn near_start(v: &Variable) -> Option<Vec<f64>> {
    let [min, max] = v.bounds();
    let near = |element| {
        let (start, scale) = start_and_scale(v, element);
        let candidates = [start + 0.01 * scale, start - 0.01 * scale];
        let mut fitting = candidates.into_iter().filter(|x| (min..=max).contains(x));
        fitting.next()
    };
    (0..v.size()).map(near).collect()
}

fn is_real_input(v: &&Variable) -> bool {
    v.is_input() && v.access() == Access::Real
}

fn read_back(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let instance = Instance::readable_after_set(fmu, "back")?;
    let is_input = |v: &&Variable| v.is_input() && v.access() != Access::Clock;
    for v in fmu.description.variables.iter().filter(is_input) {
        let Some(values) = changed_values(&instance, v)? else {
            continue;
        };
        let status = instance.set_values(v, &values);
        if status > WARNING {
            let reason = last_message(&instance.messages());
            let values = values.join(" ");
            outcome.remark(format!("`{}` = {values} was refused{reason}", v.name));
            continue;
        }
        let (status, back) = instance.values(v);
        instance.must(&format!("reading `{}`", v.name), status)?;
        if back != values {
            let (values, back) = (values.join(" "), back.join(" "));
            outcome.remark(format!(
                "`{}`: {values} was set, {back} was read back",
                v.name
            ));
        }
    }
    Ok(())
}

/// Values that an input does not have now; None if there are none within its bounds.
fn changed_values(instance: &Instance, v: &Variable) -> Result<Option<Vec<String>>> {
    if v.access() == Access::Real {
        let values = near_start(v);
        return Ok(values.map(|values| values.iter().map(f64::to_string).collect()));
    }
    let (status, values) = instance.values(v);
    instance.must(&format!("reading `{}`", v.name), status)?;
    let changed = |value: &String| match v.access() {
        Access::Boolean => Some((value != "true").to_string()),
        Access::String => Some(format!("{value}x")),
        Access::Binary => Some(format!("{value}0a")),
        Access::Float32 => None, // not tried: read and written like Float64, which is
        _ => {
            let ([min, max], value) = (v.bounds(), value.parse::<i128>().ok()?);
            let candidates = [value ^ 1, value + 1].into_iter();
            let mut fitting = candidates.filter(|k| (min..=max).contains(&(*k as f64)));
            fitting.next().map(|k| k.to_string())
        }
    };
    Ok(values.iter().map(changed).collect())
}

/// Why outputs cannot be read after an input was set, as FMI 3.0 forbids it without Event Mode.
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
        let Some(value) = near_start(input) else {
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
