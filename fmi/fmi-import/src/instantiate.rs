//! Makes an instance for a master from the functions of a library.

use std::sync::Arc;

use anyhow::{Result, ensure};

use crate::batch::Layout;
use crate::clocks::Plan;
use crate::fmi_instance::{Arguments, FmiInstance};
#[cfg(feature = "native")]
use crate::fmi2;
use crate::fmi3;
use crate::functions::{Functions, OwnFunctions};
use crate::log::Log;
use crate::raw::{CallbackSet, InstanceKind, RawInstance, Request};

/// An instance for co-simulation; none where the FMU gives none.
///
/// # Errors
/// The library does not export what makes and frees instances.
pub fn instantiate(
    functions: &Arc<Functions>,
    layout: &Layout,
    plan: &Arc<Plan>,
    arguments: &Arguments,
) -> Result<Option<Box<dyn FmiInstance>>> {
    let needed = ["fmi2Instantiate", "fmi2FreeInstance"].map(|name| functions.name(name));
    ensure!(
        needed.iter().all(|name| functions.exports(name)),
        "its library does not export {} and {}",
        needed[0],
        needed[1]
    );
    let request = Request {
        kind: InstanceKind::CoSimulation,
        name: Some(&arguments.name),
        token: Some(&arguments.token),
        resources: Some(&arguments.resources),
        is_logging: true,
        has_events: arguments.has_events,
        returns_early: arguments.returns_early,
        given: CallbackSet::LoggerAndMemory,
    };
    let log = Log::of_thread(&arguments.name.to_string_lossy());
    let Ok(raw) = RawInstance::new(functions, &request, log) else {
        return Ok(None);
    };
    Ok(match &functions.own {
        #[cfg(feature = "native")]
        OwnFunctions::Fmi2(api) => Some(Box::new(fmi2::Component::new(api.clone(), raw))),
        #[cfg(not(feature = "native"))]
        OwnFunctions::Fmi2(_) => None,
        OwnFunctions::Fmi3(api) => {
            let instance = fmi3::Instance::new(api.clone(), raw, layout, plan, arguments);
            Some(Box::new(instance))
        }
    })
}
