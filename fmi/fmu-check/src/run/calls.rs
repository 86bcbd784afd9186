//! Probes of the call order, and of the messages that the logger receives, for `supervision`.

use std::ffi::c_int;

use super::probe::probes;
use super::simulation::is_odd;
use crate::outcome::Outcome;
use anyhow::Result;
use fmi_description::{Access, Variable};
use fmi_import::Fmu;
use fmi_import::instance::{Instance, InstanceOptions, references, start_time, step_size};
use fmi_import::log::Message;
use fmi_import::raw::{Array, Experiment, RawInstance, StepEnd};
use fmi_import::standard::{Mode, is_allowed};
use fmi_import::status::{self, ERROR, WARNING};

probes! {
    "misuse" {
        opened order:
            "calls out of order are refused",
            "an importer that calls in a wrong order gets meaningless numbers";
    }
    "log" {
        opened messages:
            "messages have a declared category, come from the instance, and tell why a call failed",
            "users filter by category, and see nothing but the message when a simulation fails [FMI 2.0, 2.1.5; FMI 3.0, 2.3.1]";
        opened quiet:
            "with loggingOn = false a run without errors sends no message",
            "logs of long simulations fill up [FMI 3.0, 2.3.1]";
    }
}

/// The modes that the FMU has.
fn modes(fmu: &Fmu) -> Vec<Mode> {
    let exists = |mode: &Mode| match mode {
        Mode::Event => fmu.functions.has_event_mode(),
        Mode::SteppingAfterSet => fmu.functions.is_fmi3() && scalar_input(fmu).is_some(),
        _ => true,
    };
    Mode::ALL.into_iter().filter(exists).collect()
}

/// A Real input that is a scalar.
fn scalar_input(fmu: &Fmu) -> Option<&Variable> {
    let mut variables = fmu.description.variables.iter();
    variables.find(|v| v.is_input() && v.access() == Access::Real && v.size() == 1)
}

fn in_mode(fmu: &Fmu, mode: Mode) -> Result<Instance<'_>> {
    if mode == Mode::Instantiated {
        return Instance::new(fmu, "order");
    }
    let mut instance = Instance::initializing(fmu, "order")?;
    if mode == Mode::Initialization {
        return Ok(instance);
    }
    instance.enter(Mode::Stepping)?;
    instance.step(step_size(fmu))?;
    if mode == Mode::Terminated {
        instance.enter(Mode::Terminated)?;
    }
    if fmu.functions.is_fmi3() && matches!(mode, Mode::Stepping | Mode::SteppingAfterSet) {
        instance.enter_step_mode()?;
    }
    if mode == Mode::SteppingAfterSet
        && let Some(v) = scalar_input(fmu)
    {
        let status = instance.set_reals(&[v.reference], &[v.start_number().unwrap_or(0.0)]);
        instance.must("fmi2SetReal", status)?;
    }
    Ok(instance)
}

/// Functions that are not allowed in every mode. They are called with valid arguments.
const CALLS: [&str; 6] = [
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2DoStep",
    "fmi2Terminate",
    "fmi2GetReal",
];

/// Further functions that FMI 3.0 has.
const CALLS_3: [&str; 3] = [
    "fmi3EnterEventMode",
    "fmi3EnterStepMode",
    "fmi3EvaluateDiscreteStates",
];

fn call(instance: &Instance, name: &str) -> c_int {
    let (t, h) = (instance.time, step_size(instance.fmu));
    match name {
        "fmi3EnterEventMode" => instance.enter_event_mode(),
        "fmi3EnterStepMode" => RawInstance::enter_step_mode(instance),
        "fmi3EvaluateDiscreteStates" => instance.evaluate_discrete_states(),
        "fmi2SetupExperiment" => instance.setup_experiment(Experiment::default()),
        "fmi2EnterInitializationMode" => instance.enter_initialization_mode(Experiment::default()),
        "fmi2ExitInitializationMode" => instance.exit_initialization_mode(),
        "fmi2DoStep" => instance.do_step(t, h, 1, &mut StepEnd::default()),
        "fmi2Terminate" => instance.terminate(),
        _ => instance.reals(&reals(instance.fmu)).0,
    }
}

fn reals(fmu: &Fmu) -> Vec<u32> {
    references(&fmu.description.variables, |v| v.access() == Access::Real)
}

fn order(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let names: Vec<&str> = match fmu.functions.is_fmi3() {
        false => CALLS.to_vec(),
        true => CALLS[1..].iter().chain(&CALLS_3).copied().collect(),
    };
    let is_callable = |name: &&&str| **name != "fmi2GetReal" || !reals(fmu).is_empty();
    let modes = modes(fmu);
    let mut tried = 0;
    for (name, mode) in names
        .iter()
        .filter(is_callable)
        .flat_map(|name| modes.iter().map(|mode| (*name, *mode)))
    {
        if is_allowed(fmu.functions.name(name), mode) {
            continue;
        }
        let instance = in_mode(fmu, mode)?;
        let status = call(&instance, name);
        tried += 1;
        if is_odd(status) {
            outcome.fail(format!("{name} in {mode:?} gave {}", status::name(status)));
        } else if status <= WARNING {
            outcome.remark(format!("{name} was accepted in state {mode:?}"));
        }
    }
    outcome.note(format!("{tried} calls"));
    Ok(())
}

fn messages(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let logging = InstanceOptions {
        is_logging: true,
        ..InstanceOptions::USUAL
    };
    let mut instance = Instance::with_options(fmu, "talker", logging)?;
    let status = instance.set_debug_logging(true, Array::Null(0));
    instance.must("fmi2SetDebugLogging", status)?;
    let mut received = instance.messages();
    instance.initialize()?;
    instance.step(step_size(fmu))?;
    received.extend(instance.messages());
    // What the standard makes fail: a step beyond the stop time.
    let h = step_size(fmu);
    instance.enter(Mode::Instantiated)?;
    instance.initialize_between(start_time(fmu), Some(start_time(fmu) + h))?;
    instance.step(h)?;
    let status = instance.step_from(instance.time, h);
    let answer = instance.messages();
    if status >= ERROR && answer.is_empty() {
        outcome.remark("a step beyond the stop time failed without a message");
    }
    received.extend(answer);
    // An instance that is refused may log why.
    let refused = InstanceOptions {
        token: Some("{wrong}"),
        ..logging
    };
    if !fmu.description.capabilities.only_once {
        let _ = Instance::with_options(fmu, "talker", refused); // another probe checks that it is refused
    }
    received.extend(instance.messages());
    for message in received.iter().filter(|m| m.is_stray) {
        outcome.fail(format!(
            "a message came with another environment than fmi2Instantiate was given: {}",
            message.format
        ));
    }
    for message in &received {
        if let Some(what) = fault(fmu, message) {
            outcome.fail(format!("{what}: {}", message.format));
        }
    }
    outcome.note(format!("{} messages", received.len()));
    outcome.fails.dedup();
    outcome.remarks.dedup();
    Ok(())
}

/// What is wrong with a message, if anything.
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
    (!(0..=5).contains(status)).then(|| format!("the message has status {status}"))
}

fn quiet(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "quiet")?;
    (0..3).try_for_each(|_| instance.step(step_size(fmu)))?;
    let messages = instance.messages().into_iter();
    let messages = messages.filter(|m| m.status < WARNING).map(|m| m.format);
    // FMI 2.0 says that they should not come, FMI 3.0 that they must not.
    match fmu.functions.is_fmi3() {
        true => outcome.fails.extend(messages),
        false => outcome.remarks.extend(messages),
    }
    Ok(())
}
