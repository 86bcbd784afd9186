//! Probes with wrong calls, for `supervision`. They must be refused, and must not change what the
//! instance does afterwards. The standard forbids importers to make them, so whatever an FMU does,
//! it is not robust at worst.

use std::ffi::c_int;

use anyhow::Result;
use fmi_description::{Access, Causality, Variability, Variable};

use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, references, step_size};
use fmi_import::raw::{Array, Experiment, RawInstance, StepEnd};
use fmi_import::status::WARNING;

const STEPS: usize = 10;

probes! {
    "misuse" {
        opened unknown_references:
            "unknown value references are refused",
            "an importer with the description of another version reads or writes foreign memory";
        opened not_finite:
            "NaN and infinity are refused as inputs and parameters",
            "one NaN spreads through a coupled system until its source cannot be found";
        opened read_only:
            "outputs, constants and, between steps, fixed parameters cannot be set",
            "a value that is accepted without effect, or that changes a result, goes unnoticed";
        opened wrong_steps:
            "steps of length 0, below 0 or NaN, and jumps in time, are refused",
            "a master with a mistake computes wrong results unnoticed";
        opened null:
            "NULL instead of an instance or an array is refused",
            "an instantiation that failed without being noticed takes the importer down";
    }
}

/// Lets `wrong` make calls on an instance in the middle of a run; it returns their names and
/// statuses. Accepted calls are remarks, and so is a run that differs afterwards from one without
/// these calls.
fn must_refuse(
    fmu: &Fmu,
    outcome: &mut Outcome,
    wrong: impl Fn(&Instance) -> Vec<(String, c_int)>,
) -> Result<()> {
    let mut undisturbed = Instance::started(fmu, "undisturbed")?;
    undisturbed.run_excited(STEPS, 0)?;
    let expected = undisturbed.run_excited(STEPS, STEPS)?;
    drop(undisturbed); // the FMU may allow one instance only
    let mut instance = Instance::started(fmu, "misused")?;
    instance.run_excited(STEPS, 0)?;
    let answers = wrong(&instance);
    let made = answers.len();
    let accepted: Vec<_> = answers
        .into_iter()
        .filter(|(_, status)| *status <= WARNING)
        .collect();
    for (call, _) in &accepted {
        outcome.remark(format!("{call} was accepted"));
    }
    if made == 0 {
        outcome.not_checked = Some("there is no variable to try it with".into());
        return Ok(());
    }
    if !accepted.is_empty() {
        return Ok(()); // nothing is promised after an accepted wrong call
    }
    outcome.note(format!("{made} calls"));
    match instance.run_excited(STEPS, STEPS) {
        Ok(bits) if bits == expected => {}
        Ok(_) => outcome.remark("results differ after rejected calls"),
        Err(reason) => outcome.remark(format!("after rejected calls it does not go on: {reason}")),
    }
    Ok(())
}

/// Value references that no variable has: the one after the last, and the largest.
fn unknown(fmu: &Fmu) -> [u32; 2] {
    let known = references(&fmu.description.variables, |_| true);
    let last = known.iter().max().copied().unwrap_or(0);
    [last.saturating_add(1), u32::MAX]
}

fn unknown_references(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    must_refuse(fmu, outcome, |instance| {
        let mut answers = Vec::new();
        let is_tried = |access: &Access| access.is_number() || *access == Access::String;
        let accesses = instance.fmu.accesses().into_iter().filter(is_tried);
        let accesses: Vec<_> = accesses.collect();
        for vr in unknown(instance.fmu) {
            let mut note = |name: &str, status| answers.push((format!("{name} of {vr}"), status));
            let names = |access| instance.fmu.functions.names_of(access);
            // All are read before one is set: FMI 3.0 forbids reading in Step Mode after a set.
            for &access in &accesses {
                note(names(access)[0], instance.values_of(access, &[vr], false).0);
            }
            for &access in &accesses {
                let value = [if access.is_number() { "0" } else { "" }.to_string()];
                let status = instance.set_values_of(access, &[vr], &value, [false; 2]);
                note(names(access)[1], status);
            }
        }
        answers
    })
}

fn not_finite(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    must_refuse(fmu, outcome, |instance| {
        let variables = &instance.fmu.description.variables;
        let is_settable =
            |v: &&Variable| v.access() == Access::Real && (v.is_input() || v.is_tunable());
        let mut answers = Vec::new();
        // All are read before one is set: FMI 3.0 forbids reading in Step Mode after a set.
        let settable = variables.iter().filter(is_settable);
        let present: Vec<_> = settable
            .map(|v| (v, instance.reals(&[v.reference]).1))
            .collect();
        for (v, old) in present {
            for value in [f64::NAN, f64::INFINITY] {
                let status = instance.set_reals(&[v.reference], &vec![value; v.size()]);
                answers.push((format!("fmi2SetReal of `{}` to {value}", v.name), status));
                if status <= WARNING {
                    instance.set_reals(&[v.reference], &old);
                }
            }
        }
        answers
    })
}

fn read_only(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    must_refuse(fmu, outcome, |instance| {
        let variables = &instance.fmu.description.variables;
        let is_fixed = |v: &&Variable| {
            let is_read_only = matches!(
                v.causality,
                Causality::Output | Causality::CalculatedParameter
            ) || v.variability == Variability::Constant
                || (v.causality == Causality::Parameter && v.variability == Variability::Fixed);
            v.access() == Access::Real && is_read_only
        };
        let mut answers = Vec::new();
        let fixed = variables.iter().filter(is_fixed);
        let present: Vec<_> = fixed
            .map(|v| (v, instance.reals(&[v.reference]).1))
            .collect();
        for (v, now) in present {
            let status = instance.set_reals(&[v.reference], &now);
            answers.push((format!("fmi2SetReal of `{}`", v.name), status));
        }
        answers
    })
}

fn wrong_steps(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let h = step_size(fmu);
    let jumps = [
        ("by 0 s", 0.0, 0.0),
        ("backwards", 0.0, -h),
        ("by NaN", 0.0, f64::NAN),
        ("by infinity", 0.0, f64::INFINITY),
        ("from ten steps ahead", 10.0 * h, h),
        ("from five steps back", -5.0 * h, h),
        ("from NaN", f64::NAN, h),
    ];
    for (what, shift, h) in jumps {
        // An accepted step changes the time, so each is tried on a new instance.
        must_refuse(fmu, outcome, |instance| {
            let status = instance.step_from(instance.time + shift, h);
            vec![(format!("fmi2DoStep {what}"), status)]
        })?;
    }
    outcome.notes = vec![format!("{} calls", jumps.len())];
    Ok(())
}

fn null(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    must_refuse(fmu, outcome, |instance| {
        let null = RawInstance::null(&instance.fmu.functions);
        let begun = null.enter_initialization_mode(Experiment::default());
        let stepped = null.do_step(0.0, 0.1, 1, &mut StepEnd::default());
        let mut answers = vec![
            ("fmi2EnterInitializationMode(NULL)", begun),
            (
                "fmi2ExitInitializationMode(NULL)",
                null.exit_initialization_mode(),
            ),
            ("fmi2DoStep(NULL, …)", stepped),
            ("fmi2Reset(NULL)", null.reset()),
            ("fmi2Terminate(NULL)", null.terminate()),
        ];
        let mut variables = instance.fmu.description.variables.iter();
        let real = variables.find(|v| v.access() == Access::Real && v.size() == 1);
        if let Some(v) = real {
            let (vr, none) = (
                Array::Elements(std::slice::from_ref(&v.reference)),
                Array::Null(1),
            );
            let (given, no_values, mut place) = (Array::Elements(&[0.0]), Array::Null(1), [0.0]);
            let got = null.get_reals(vr, Some(&mut place));
            let of_nothing = instance.get_reals(none, Some(&mut place));
            let raw: &RawInstance = instance;
            answers.extend([
                ("fmi2GetReal(NULL, …)", got),
                ("fmi2SetReal(NULL, …)", null.set_reals(vr, given)),
                ("fmi2GetReal(…, vr = NULL, 1, …)", of_nothing),
                ("fmi2GetReal(…, value = NULL)", raw.get_reals(vr, None)),
                ("fmi2SetReal(…, value = NULL)", raw.set_reals(vr, no_values)),
            ]);
        }
        let answers = answers.into_iter();
        answers
            .map(|(call, status)| (call.to_string(), status))
            .collect()
    })
}
