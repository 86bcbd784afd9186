//! Makes an instance for a co-simulation master (`cosim`) from the functions of a library.

use std::sync::Arc;

use anyhow::{Result, ensure};

use crate::batch::Layout;
use crate::clocks::ClockPlan;
use crate::fmi_instance::{Arguments, FmiInstance};
#[cfg(feature = "native")]
use crate::fmi2::Fmi2Instance;
use crate::fmi3::Fmi3Instance;
use crate::functions::{Functions, VersionFunctions};
use crate::log::Log;
use crate::raw::{CallbackSet, InstanceKind, RawInstance, Request};

/// Makes an instance for co-simulation; None if the FMU returns NULL.
///
/// # Errors
/// The library does not export the functions that make and free instances.
pub fn instantiate(
    functions: &Arc<Functions>,
    layout: &Layout,
    plan: &Arc<ClockPlan>,
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
        is_logging: arguments.is_logging,
        has_events: arguments.has_events,
        returns_early: arguments.returns_early,
        given: CallbackSet::LoggerAndMemory,
    };
    let log = Log::for_thread(&arguments.name.to_string_lossy());
    let Ok(raw) = RawInstance::new(functions, &request, log) else {
        return Ok(None);
    };
    Ok(match &functions.version {
        #[cfg(feature = "native")]
        VersionFunctions::Fmi2(_) => Some(Box::new(Fmi2Instance::new(raw))),
        #[cfg(not(feature = "native"))]
        VersionFunctions::Fmi2(_) => None,
        VersionFunctions::Fmi3(_) => {
            Some(Box::new(Fmi3Instance::new(raw, layout, plan, arguments)))
        }
    })
}
