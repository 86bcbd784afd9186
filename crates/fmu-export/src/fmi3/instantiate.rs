//! Instantiation, and its end.

use super::description::check;
use super::ffi::*;
use super::instance::{Body, Fmi3, Update};
use super::log;
use crate::Model;
use crate::border::answer::Answer;
use crate::border::arguments::array;
use crate::border::call::{CS, ME, S};
use crate::border::export::Exported;
use crate::border::library::{self, Library, Request, refusal, text};
use crate::core::fault::Fault;
use crate::core::layout::Layout;
use crate::core::message::{Kind, Message};
use crate::core::panic;
use std::path::{Path, PathBuf};
use std::ptr;

/// What both interfaces say of a new instance.
struct Arguments<'a> {
    library: &'a Library,
    function: &'static str,
    name: Str,
    token: Str,
    resources: Str,
    log: log::Log,
}

/// fmi3InstantiateCoSimulation.
///
/// # Safety
/// As for every function of [`entry`](super::entry); the callbacks may be called until
/// fmi3FreeInstance.
#[expect(clippy::too_many_arguments, reason = "those of FMI")]
pub unsafe fn instantiate_co_simulation<X: Exported>(
    library: &Library,
    name: Str,
    token: Str,
    resources: Str,
    logging_on: Boolean,
    event_mode_used: Boolean,
    early_return_allowed: Boolean,
    required: *const ValueReference,
    n_required: usize,
    environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
    update: Option<IntermediateUpdate>,
) -> Instance {
    let own = Fmi3 {
        has_event_mode: event_mode_used != 0,
        may_return_early: early_return_allowed != 0,
        stepping: S,
        update: None,
    };
    let log = new_log::<X>(logging_on, environment, log_message);
    let function = "fmi3InstantiateCoSimulation";
    let arguments = Arguments {
        library,
        function,
        name,
        token,
        resources,
        log,
    };
    // SAFETY: forwarded.
    unsafe {
        let required = array("requiredIntermediateVariables", required, n_required);
        instantiate::<X>(arguments, CS, own, |body| {
            let required = required.map_err(reason)?;
            let variables = (0..n_required).map(|k| required.get(k)).collect();
            body.own.update = updates(&body.instance.layout, variables, environment, update)?;
            Ok(())
        })
    }
}

/// fmi3InstantiateModelExchange.
///
/// # Safety
/// As for every function of [`entry`](super::entry); the logger may be called until
/// fmi3FreeInstance.
pub unsafe fn instantiate_model_exchange<X: Exported>(
    library: &Library,
    name: Str,
    token: Str,
    resources: Str,
    logging_on: Boolean,
    environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
) -> Instance {
    let function = "fmi3InstantiateModelExchange";
    if X::Model::MODEL_EXCHANGE.is_none() {
        // SAFETY: forwarded.
        return unsafe {
            refuse_instantiation::<X>(function, logging_on, environment, log_message)
        };
    }
    let own = Fmi3 {
        has_event_mode: false,
        may_return_early: false,
        stepping: S,
        update: None,
    };
    let log = new_log::<X>(logging_on, environment, log_message);
    let arguments = Arguments {
        library,
        function,
        name,
        token,
        resources,
        log,
    };
    // SAFETY: forwarded.
    unsafe { instantiate::<X>(arguments, ME, own, |_| Ok(())) }
}

unsafe fn instantiate<X: Exported>(
    Arguments {
        library,
        function,
        name,
        token,
        resources,
        log,
    }: Arguments,
    interface: u16,
    own: Fmi3,
    prepare: impl FnOnce(&mut Body<X::Model>) -> Result<(), String>,
) -> Instance {
    panic::silence(library.is_program);
    // SAFETY: forwarded.
    let (name, token, resources) = unsafe { (text(name), text(token), text(resources)) };
    let mut messages = Vec::new();
    let resources = resources.and_then(|path| folder(&mut messages, function, &path));
    let request = Request {
        function,
        log,
        messages,
        name: name.as_deref(),
        token: ("instantiationToken", token.as_deref()),
        sizes: library.sizes,
        hash: &library.hashes[1],
        resources,
        interface,
        own,
    };
    request.make::<X::Model>(check, prepare)
}

fn new_log<X: Exported>(
    logging_on: Boolean,
    environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
) -> log::Log {
    log::new(
        log_message,
        environment,
        logging_on != 0,
        X::Model::INFO.log_categories,
    )
}

fn reason(fault: Fault) -> String {
    match fault {
        Fault::Refused(text) | Fault::Discarded(text) => text,
        Fault::Unknown(number) => format!("unknown value reference {number}"),
    }
}

/// What the importer wants to see within steps, if anything.
fn updates<M: Model>(
    layout: &Layout<M>,
    variables: Vec<ValueReference>,
    environment: InstanceEnvironment,
    callback: Option<IntermediateUpdate>,
) -> Result<Option<Update>, String> {
    for &number in &variables {
        let (run, first, _) = layout.block(number).map_err(|_| {
            format!("requiredIntermediateVariables: unknown value reference {number}")
        })?;
        if !run.row.has_intermediate_update() {
            let name = run.row.element_name(first);
            return Err(format!(
                "requiredIntermediateVariables: `{name}` must be a variable with intermediateUpdate = true"
            ));
        }
    }
    match callback {
        _ if variables.is_empty() => Ok(None),
        None => Err(
            "intermediateUpdate = NULL must be a function, because there are requiredIntermediateVariables"
                .to_owned(),
        ),
        Some(callback) => Ok(Some(Update {
            callback,
            environment,
            variables,
        })),
    }
}

/// The resources folder; one that is not absolute is reported and done without.
fn folder(messages: &mut Vec<Message>, function: &str, path: &str) -> Option<PathBuf> {
    let folder = Path::new(path);
    // In a WebAssembly module the folder is the beginning of the paths of files that its host places.
    if folder.is_absolute() || cfg!(target_arch = "wasm32") {
        // Without the separator at the end.
        return Some(folder.components().collect());
    }
    messages.push(Message::new(
        Kind::Warning,
        format!("{function}: resourcePath `{path}` is not an absolute path; going on without"),
    ));
    None
}

/// fmi3InstantiateModelExchange and fmi3InstantiateScheduledExecution: refused by name.
///
/// # Safety
/// As for every function of [`entry`](super::entry).
pub unsafe fn refuse_instantiation<X: Exported>(
    function: &str,
    logging_on: Boolean,
    environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
) -> Instance {
    let log = new_log::<X>(logging_on, environment, log_message);
    let reason = match X::Model::MODEL_EXCHANGE {
        None => {
            "this FMU offers Co-Simulation only; it must be instantiated by fmi3InstantiateCoSimulation"
        }
        Some(_) => {
            "this FMU offers Co-Simulation and Model Exchange; it must be instantiated for one of them"
        }
    };
    log.send(&[refusal(function, reason)], Answer::Error);
    ptr::null_mut()
}

/// fmi3FreeInstance; NULL is ignored, and so is an instance in use: a callback cannot free its
/// instance.
///
/// # Safety
/// As for every function of [`entry`](super::entry); `c` is not used afterwards.
pub unsafe fn free_instance<X: Exported>(c: Instance) {
    // SAFETY: forwarded.
    unsafe { library::free::<X::Model, Fmi3>(c) }
}
