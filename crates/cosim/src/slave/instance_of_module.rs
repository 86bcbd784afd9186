//! Instances of FMUs that are WebAssembly modules, which have the functions of FMI 3.0.

use anyhow::{Result, bail};

use super::border::{Arguments, Border};
use super::fmi3;
use crate::fmu::{Api, Fmu};

/// An instance; none where the FMU gives none.
pub fn make(fmu: &Fmu, api: &Api, arguments: &Arguments) -> Result<Option<Box<dyn Border>>> {
    let Api::Fmi3(api) = api else {
        bail!("WebAssembly modules of FMUs have the functions of FMI 3.0 only");
    };
    let made = fmi3::Instance::new(api, &fmu.layout, &fmu.plan, arguments)?;
    Ok(made.map(|instance| Box::new(instance) as Box<dyn Border>))
}
