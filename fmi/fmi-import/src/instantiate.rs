//! Makes an instance for a co-simulation master (`cosim`) from the functions of a library.

use std::rc::Rc;
use std::sync::Arc;

use anyhow::{Result, ensure};

use crate::batch::Layout;
use crate::clocks::ClockPlan;
use crate::exchange::{ExchangeInstance, ExchangePlan};
use crate::fmi_instance::{Arguments, FmiInstance};
#[cfg(feature = "native")]
use crate::fmi2::Fmi2Instance;
use crate::fmi3::Fmi3Instance;
use crate::functions::{Functions, VersionFunctions};
use crate::log::Log;
use crate::raw::{CallbackSet, InstanceKind, RawInstance, Request};

/// Makes an instance, for Model Exchange if there is a plan to integrate it, else for
/// Co-Simulation; None if the FMU returns NULL.
///
/// # Errors
/// The library does not export the functions that make and free instances.
pub fn instantiate(
    functions: &Arc<Functions>,
    layout: &Layout,
    plan: &Arc<ClockPlan>,
    exchange: Option<&Arc<ExchangePlan>>,
    arguments: &Arguments,
) -> Result<Option<Box<dyn FmiInstance>>> {
    let made_by = match exchange {
        Some(_) if functions.is_fmi3() => "fmi3InstantiateModelExchange",
        None if plan.is_scheduled => "fmi3InstantiateScheduledExecution",
        _ => functions.name("fmi2Instantiate"),
    };
    let needed = [made_by, functions.name("fmi2FreeInstance")];
    ensure!(
        needed.iter().all(|name| functions.exports(name)),
        "its library does not export {} and {}",
        needed[0],
        needed[1]
    );
    let request = Request {
        kind: match exchange {
            Some(_) => InstanceKind::ModelExchange,
            None if plan.is_scheduled => InstanceKind::ScheduledExecution,
            None => InstanceKind::CoSimulation,
        },
        name: Some(&arguments.name),
        token: Some(&arguments.token),
        resources: Some(&arguments.resources),
        is_logging: arguments.is_logging,
        has_events: arguments.has_events,
        returns_early: arguments.returns_early,
        given: CallbackSet::LoggerAndMemory,
    };
    let log = Log::for_thread(&arguments.name.to_string_lossy());
    let Ok(raw) = RawInstance::new(functions, &request, log) else {
        return Ok(None);
    };
    let raw = Rc::new(raw);
    let instance: Box<dyn FmiInstance> = match &functions.version {
        #[cfg(feature = "native")]
        VersionFunctions::Fmi2(_) => Box::new(Fmi2Instance::new(raw.clone())),
        #[cfg(not(feature = "native"))]
        VersionFunctions::Fmi2(_) => return Ok(None),
        VersionFunctions::Fmi3(_) => {
            let is_exchange = exchange.is_some();
            let raw = raw.clone();
            Box::new(Fmi3Instance::new(raw, layout, plan, arguments, is_exchange))
        }
    };
    Ok(Some(match exchange {
        Some(exchange) => Box::new(ExchangeInstance::new(raw, instance, exchange)),
        None => instance,
    }))
}
