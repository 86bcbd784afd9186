//! Probes of values set and read, and of outputs that inputs act on at once, for `supervision`.

use std::ffi::c_int;

use anyhow::Result;
use fmi_description::{Access, Causality, Initial, Variability, Variable};

use super::dependence::{self, Computed};
use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, last_message, start_and_scale, step_size};
use fmi_import::status::{OK, WARNING};

probes! {
    "values" {
        opened starts:
            "parameters and inputs begin at the start values of the description",
            "tools show those to their users, and set only what differs from them [FMI 2.0, 2.2.7; FMI 3.0, 2.4.7.4]";
        opened read_back:
            "an input that is set is read back bit for bit",
            "importers and users check what they have set";
        opened dependencies.unless(without_reading_after_set):
            "an input acts at once only on outputs that list it in their dependencies",
            "importers read outputs before such inputs are set, and then compute with old values [FMI 2.0, 2.2.8; FMI 3.0, 2.4.8]";
    }
}

/// Whether a variable must hold its start value before anything was set.
fn is_given(v: &Variable) -> bool {
    let is_set = matches!(v.causality, Causality::Parameter | Causality::Input);
    is_set || v.initial == Some(Initial::Exact) || v.variability == Variability::Constant
}

fn starts(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    // FMI 2.0 (section 4.2.4) lets nothing but unknowns be read in Initialization Mode, and
    // everything right after it.
    let instance = match fmu.functions.is_fmi3() {
        true => Instance::initializing(fmu, "starts")?,
        false => Instance::started(fmu, "starts")?,
    };
    for v in fmu.description.variables.iter().filter(|v| is_given(v)) {
        if v.start.is_empty() || v.access() == Access::Clock {
            continue;
        }
        let (status, values) = instance.values(v);
        instance.must(
            &format!("reading `{}` before the first step", v.name),
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
        // Descriptions are often written with fewer digits than there are.
        Access::Real | Access::Float32 => {
            let rounding = if access == Access::Real { 1e-12 } else { 1e-6 };
            let [a, b] = [a, b].map(|text| text.parse::<f64>().unwrap_or(f64::NAN));
            a == b || (a - b).abs() <= rounding * a.abs()
        }
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

/// Whether it can be set and read between the ticks of clocks.
fn is_unclocked(v: &Variable) -> bool {
    v.access() != Access::Clock && v.clocks.is_empty()
}

fn read_back(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let instance = Instance::readable_after_set(fmu, "back")?;
    let is_input = |v: &&Variable| v.is_input() && is_unclocked(v);
    for v in fmu.description.variables.iter().filter(is_input) {
        let (status, old) = instance.values(v);
        instance.must(&format!("reading `{}`", v.name), status)?;
        let Some(values) = changed_values(v, &old) else {
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
fn changed_values(v: &Variable, now: &[String]) -> Option<Vec<String>> {
    if v.access() == Access::Real {
        return near_start(v).map(|values| values.iter().map(f64::to_string).collect());
    }
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
    now.iter().map(changed).collect()
}

/// Why outputs cannot be read after an input was set, as FMI 3.0 forbids it without Event Mode.
pub fn without_reading_after_set(fmu: &Fmu) -> Option<&'static str> {
    let reason = "FMI 3.0 lets nothing be read between a set and the next step but in Event Mode, which the FMU does not have";
    (!fmu.functions.reads_after_set()).then_some(reason)
}

/// The values of variables with these indices; the worst status if one cannot be read.
fn computed(instance: &Instance, of: &[usize]) -> Result<Computed<String>, c_int> {
    let variables = &instance.fmu.description.variables;
    let mut all = Vec::new();
    for access in instance.fmu.accesses() {
        let of = of.iter().filter(|k| variables[**k].access() == access);
        let vr: Vec<_> = of.clone().map(|k| variables[*k].reference).collect();
        if vr.is_empty() {
            continue;
        }
        let (status, values) = instance.values_of(access, &vr, false);
        if status > WARNING {
            return Err(status);
        }
        let owners = of.flat_map(|k| vec![*k; variables[*k].size()]);
        all.extend(owners.zip(values));
    }
    Ok(all)
}

fn dependencies(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "dependencies")?;
    (0..2).try_for_each(|_| instance.step(step_size(fmu)))?;
    let acting = compare(&instance, false, outcome)?;
    drop(instance); // the FMU may allow one instance only
    let initially = compare(&Instance::initializing(fmu, "initially")?, true, outcome)?;
    outcome.note(format!(
        "{acting} pairs of input and output act at once, {initially} in initialization"
    ));
    Ok(())
}

/// Moves one input at a time, and compares the outputs that move with what is declared; returns the
/// number of pairs.
fn compare(instance: &Instance, initially: bool, outcome: &mut Outcome) -> Result<usize> {
    let description = &instance.fmu.description;
    let variables = &description.variables;
    let all = 0..variables.len();
    let is_readable = |k: &usize| is_unclocked(&variables[*k]);
    let is_output = |k: &usize| variables[*k].causality == Causality::Output;
    let outputs: Vec<_> = (all.clone().filter(is_readable).filter(is_output)).collect();
    let read = || computed(instance, &outputs);
    let mut before = match read() {
        Ok(before) => before,
        Err(status) => {
            instance.must("reading all outputs", status)?;
            return Ok(0);
        }
    };
    let (mut acting, mut moves) = (0, Vec::new());
    for k in all.filter(|k| variables[*k].is_input() && is_readable(k)) {
        let v = &variables[k];
        // FMI 2.0 lets no input be read in Initialization Mode, but it has its start value.
        let start = (0..v.size()).filter_map(|e| v.start_of(e).map(String::from));
        let (status, old) = match initially {
            true => (OK, start.collect()),
            false => instance.values(v),
        };
        instance.must(&format!("reading `{}`", v.name), status)?;
        if old.len() == v.size() {
            moves.extend(changed_values(v, &old).map(|new| (k, old, new)));
        }
    }
    for (known, old, new) in moves {
        let v = &variables[known];
        if instance.set_values(v, &new) > WARNING {
            instance.messages();
            continue;
        }
        let (after, back, again) = (read(), instance.set_values(v, &old), read());
        let (Ok(after), OK | WARNING, Ok(again)) = (after, back, again) else {
            // FMI 2.0 (section 4.2.4) lets nothing be read between a set and the next step.
            outcome.note(format!("nothing can be read after `{}` was set", v.name));
            break;
        };
        acting += dependence::compare(
            description,
            known,
            [&before, &after, &again],
            initially,
            outcome,
        );
        before = again;
    }
    Ok(acting)
}
