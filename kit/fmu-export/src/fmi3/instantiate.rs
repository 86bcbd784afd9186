//! Instantiation and fmi3FreeInstance of FMI 3.0, for `entry` and WebAssembly components.

use super::description::check;
use super::ffi::*;
use super::instance::{Fmi3, Schedule, Update};
use super::log;
use crate::Model;
use crate::c_api::arguments::array;
use crate::c_api::call_order::{CS, ME, SE, STEP_MODE};
use crate::c_api::export::Exported;
use crate::c_api::library::{self, Library, Request, refusal, text};
use crate::core::fault::Fault;
use crate::core::layout::Layout;
use std::path::{Path, PathBuf};
use std::ptr;

/// The arguments that only fmi3InstantiateCoSimulation has.
pub struct CoSimulation {
    /// The importer uses Event Mode.
    pub event_mode_used: Boolean,
    /// A step may return early.
    pub early_return_allowed: Boolean,
    /// Variables that the importer reads within steps.
    pub required: *const ValueReference,
    /// Their number.
    pub n_required: usize,
    /// The callback in which it reads them.
    pub update: Option<IntermediateUpdate>,
}

/// The interface to instantiate, with the arguments that it alone has.
pub enum Interface {
    /// Co-Simulation.
    CoSimulation(CoSimulation),
    /// Model Exchange.
    ModelExchange,
    /// Scheduled Execution.
    ScheduledExecution(Option<ClockUpdate>, Option<Preemption>, Option<Preemption>),
}

/// The function that instantiates an interface.
///
/// # Safety
/// As for every function of [`entry`](super::entry); the callbacks may be called until
/// fmi3FreeInstance.
#[expect(clippy::too_many_arguments, reason = "those of FMI")]
pub unsafe fn instantiate<X: Exported>(
    library: &Library,
    name: Str,
    token: Str,
    resources: Str,
    logging_on: Boolean,
    environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
    with: Interface,
) -> Instance {
    let (function, interface, is_offered) = match with {
        Interface::CoSimulation(_) => ("fmi3InstantiateCoSimulation", CS, true),
        Interface::ModelExchange => (
            "fmi3InstantiateModelExchange",
            ME,
            X::Model::MODEL_EXCHANGE.is_some(),
        ),
        Interface::ScheduledExecution(..) => (
            "fmi3InstantiateScheduledExecution",
            SE,
            X::Model::SCHEDULED_EXECUTION,
        ),
    };
    if !is_offered {
        // SAFETY: forwarded.
        return unsafe {
            refuse_instantiation::<X>(function, logging_on, environment, log_message)
        };
    }
    library.silence_panics();
    // SAFETY: forwarded.
    let (name, token, resources) = unsafe { (text(name), text(token), text(resources)) };
    let (co_simulation, schedule) = match with {
        Interface::CoSimulation(said) => (Some(said), None),
        Interface::ModelExchange => (None, None),
        Interface::ScheduledExecution(clock_update, lock, unlock) => {
            let schedule = Schedule {
                lock,
                unlock,
                clock_update,
                environment,
            };
            (None, Some(schedule))
        }
    };
    let said = co_simulation.as_ref();
    let request = Request {
        function,
        log: log::new::<X::Model>(logging_on, environment, log_message),
        name: name.as_deref(),
        token: ("instantiationToken", token.as_deref()),
        sizes: library.sizes,
        hash: &library.hashes[1],
        resources: resources.map(|path| folder(&path)),
        interface,
        version: Fmi3 {
            has_event_mode: said.is_some_and(|said| said.event_mode_used != 0),
            may_return_early: said.is_some_and(|said| said.early_return_allowed != 0),
            step_state: STEP_MODE,
            update: None,
            schedule,
        },
    };
    request.instantiate::<X::Model>(check, |fmi| {
        let Some(said) = co_simulation else {
            return Ok(());
        };
        if !X::Model::CLOCKS.is_empty() && said.event_mode_used == 0 {
            if let Some(clock) = X::Model::CLOCKS.iter().find(|clock| clock.is_triggered()) {
                return Err(format!(
                    "eventModeUsed is false; it must be true, because clock `{}` ticks in Event Mode only",
                    clock.row.name
                ));
            }
            fmi.instance.ticks_itself = true;
        }
        let n = said.n_required;
        // SAFETY: forwarded.
        let required = unsafe { array("requiredIntermediateVariables", said.required, n) };
        let required = required.map_err(reason)?;
        let variables = (0..n).map(|k| required.get(k)).collect();
        fmi.version.update = updates(&fmi.instance.layout, variables, environment, said.update)?;
        Ok(())
    })
}

fn reason(fault: Fault) -> String {
    match fault {
        Fault::Refused(text) | Fault::Discarded(text) => text,
        Fault::Unknown(number) => format!("unknown value reference {number}"),
    }
}

/// The intermediate updates that the importer has requested, if any.
fn updates<M: Model>(
    layout: &Layout<M>,
    variables: Vec<ValueReference>,
    environment: InstanceEnvironment,
    callback: Option<IntermediateUpdate>,
) -> Result<Option<Update>, String> {
    for &number in &variables {
        let (span, first, _) = layout.block(number).map_err(|_| {
            format!("requiredIntermediateVariables: unknown value reference {number}")
        })?;
        if !span.row.has_intermediate_update() {
            let name = span.row.element_name(first);
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

/// The resources folder, which must be absolute.
fn folder(path: &str) -> Result<PathBuf, String> {
    let folder = Path::new(path);
    // In a WebAssembly module the folder is a prefix of the paths of files that its host places.
    match folder.is_absolute() || cfg!(target_arch = "wasm32") {
        true => Ok(folder.components().collect()), // without the separator at the end
        false => Err(format!("resourcePath `{path}` is not an absolute path")),
    }
}

/// Refuses to instantiate an interface that the model does not have.
///
/// # Safety
/// As for every function of [`entry`](super::entry).
unsafe fn refuse_instantiation<X: Exported>(
    function: &str,
    logging_on: Boolean,
    environment: InstanceEnvironment,
    log_message: Option<LogMessage>,
) -> Instance {
    let log = log::new::<X::Model>(logging_on, environment, log_message);
    let (has_exchange, is_scheduled) = (
        X::Model::MODEL_EXCHANGE.is_some(),
        X::Model::SCHEDULED_EXECUTION,
    );
    let reason = match (has_exchange, is_scheduled) {
        (false, false) => {
            "this FMU offers Co-Simulation only; it must be instantiated by fmi3InstantiateCoSimulation"
        }
        (true, _) => {
            "this FMU offers Co-Simulation and Model Exchange; it must be instantiated for one of them"
        }
        (false, true) => {
            "this FMU offers Co-Simulation and Scheduled Execution; it must be instantiated for one of them"
        }
    };
    log.send(&[refusal(function, reason)], Status::Error);
    ptr::null_mut()
}

/// fmi3FreeInstance; NULL and an instance in use are ignored.
///
/// # Safety
/// As for every function of [`entry`](super::entry); `c` is not used afterwards.
pub unsafe fn free_instance<X: Exported>(c: Instance) {
    // SAFETY: forwarded.
    unsafe { library::free::<X::Model, Fmi3>(c) }
}
