//! Call order, and what the logger hears.

use std::ffi::c_int;
use std::path::Path;
use std::ptr;

use super::super::outcome::Outcome;
use super::basics::is_odd;
use super::instance::{Instance, references, status_name, step_size};
use super::{Trial, open, trial};
use crate::fmi2::functions::{ERROR, WARNING};
use crate::fmi2::order::{Mode, is_allowed};
use crate::fmi2::{Fmu, Message};

pub const TRIALS: &[Trial] = &[
    trial(
        "order",
        "misuse",
        order,
        "calls out of order are refused",
        "an importer with a mistake gets numbers that mean nothing",
    ),
    trial(
        "messages",
        "log",
        messages,
        "messages have a declared category, come from the instance, and tell why a call failed",
        "users filter by category, and see nothing but the message when a simulation fails",
    ),
    trial(
        "quiet",
        "log",
        quiet,
        "with loggingOn = false a run without errors sends no message",
        "logs of long simulations fill up",
    ),
];

const MODES: [Mode; 4] = [
    Mode::Instantiated,
    Mode::Initialization,
    Mode::Stepping,
    Mode::Terminated,
];

/// An instance in a mode.
fn in_mode(fmu: &Fmu, mode: Mode) -> Result<Instance<'_>, String> {
    let mut instance = Instance::new(fmu, "order")?;
    if mode == Mode::Instantiated {
        return Ok(instance);
    }
    instance.setup(
        fmu.description.default_experiment.start.unwrap_or(0.0),
        None,
    )?;
    instance.enter(Mode::Initialization)?;
    if mode == Mode::Initialization {
        return Ok(instance);
    }
    instance.enter(Mode::Stepping)?;
    instance.step(step_size(fmu))?;
    if mode == Mode::Terminated {
        instance.enter(Mode::Terminated)?;
    }
    Ok(instance)
}

/// Functions that are not allowed everywhere, called with arguments that are right.
const CALLS: [&str; 6] = [
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2DoStep",
    "fmi2Terminate",
    "fmi2GetReal",
];

fn call(instance: &Instance, name: &str) -> c_int {
    let (f, c) = (&instance.fmu.functions, instance.c);
    let (t, h) = (instance.time, step_size(instance.fmu));
    // SAFETY: a live instance; no elements are asked for.
    unsafe {
        match name {
            "fmi2SetupExperiment" => (f.fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0),
            "fmi2EnterInitializationMode" => (f.fmi2EnterInitializationMode)(c),
            "fmi2ExitInitializationMode" => (f.fmi2ExitInitializationMode)(c),
            "fmi2DoStep" => (f.fmi2DoStep)(c, t, h, 1),
            "fmi2Terminate" => (f.fmi2Terminate)(c),
            _ => {
                instance
                    .reals(&references(&instance.fmu.description.variables, |v| {
                        v.access() == fmu_description::Access::Real
                    }))
                    .0
            }
        }
    }
}

fn order(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    let mut tried = 0;
    for (name, mode) in CALLS
        .iter()
        .flat_map(|name| MODES.map(|mode| (*name, mode)))
    {
        if is_allowed(name, mode) {
            continue;
        }
        let instance = in_mode(&fmu, mode)?;
        let status = call(&instance, name);
        tried += 1;
        if is_odd(status) {
            outcome.fail(format!("{name} in {mode:?} gave {}", status_name(status)));
        } else if status <= WARNING {
            outcome.remark(format!("{name} was accepted in state {mode:?}"));
        }
    }
    outcome.note(format!("{tried} calls"));
    Ok(())
}

fn messages(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    let mut instance = Instance::with(&fmu, "talker", &fmu.description.guid, true)?;
    // SAFETY: a live instance; no categories are named.
    let status = unsafe { (fmu.functions.fmi2SetDebugLogging)(instance.c, 1, 0, ptr::null()) };
    instance.must("fmi2SetDebugLogging", status)?;
    let mut heard = instance.messages();
    instance.initialize()?;
    instance.step(step_size(&fmu))?;
    heard.extend(instance.messages());
    let status = instance.set_reals(&[u32::MAX], &[0.0]);
    let answer = instance.messages();
    if status >= ERROR && answer.is_empty() {
        outcome.remark("fmi2SetReal of an unknown reference failed without a message");
    }
    heard.extend(answer);
    for message in &heard {
        if let Some(what) = fault(&fmu, message) {
            outcome.remark(format!("{what}: {}", message.format));
        }
    }
    outcome.note(format!("{} messages", heard.len()));
    outcome.remarks.dedup();
    Ok(())
}

fn fault(fmu: &Fmu, message: &Message) -> Option<String> {
    let declared = &fmu.description.log_categories;
    let Message {
        category,
        instance,
        status,
        ..
    } = message;
    if !declared.is_empty() && !declared.contains(category) {
        return Some(format!("category `{category}` is not declared"));
    }
    if instance != "talker" {
        return Some(format!(
            "the message says it is from `{instance}`, not from `talker`"
        ));
    }
    is_odd(*status).then(|| format!("the message has status {status}"))
}

fn quiet(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    let mut instance = Instance::started(&fmu, "quiet")?;
    (0..3).try_for_each(|_| instance.step(step_size(&fmu)))?;
    for message in instance.messages().iter().filter(|m| m.status < WARNING) {
        outcome.remark(message.format.clone());
    }
    Ok(())
}
