//! Instances of FMUs of both versions, made from their libraries.

use anyhow::Result;

use super::border::{Arguments, Border};
#[cfg(feature = "native")]
use super::fmi2;
use super::fmi3;
use crate::fmu::{Api, Fmu};
use crate::io::output;

/// An instance of the library `api`; none where the FMU gives none. What it prints meanwhile is
/// named as its own.
pub fn make(fmu: &Fmu, api: &Api, arguments: &Arguments) -> Result<Option<Box<dyn Border>>> {
    let who = format!("{} (FMU `{}`)", arguments.name.to_string_lossy(), fmu.file);
    output::named(&who, || match api {
        #[cfg(feature = "native")]
        Api::Fmi2(api) => fmi2::Component::new(api, arguments)
            .map(|made| made.map(|component| Box::new(component) as Box<dyn Border>)),
        Api::Fmi3(api) => fmi3::Instance::new(api, &fmu.layout, &fmu.plan, arguments)
            .map(|made| made.map(|instance| Box::new(instance) as Box<dyn Border>)),
    })
}
