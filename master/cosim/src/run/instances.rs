//! Instances of a system's components, with their start values.

use anyhow::{Context, Result};

use crate::instance::workers::Worker;
use crate::instance::{At, Call, Instance};
use crate::run::spare;
use crate::structure::system::{Setting, System};
use crate::wiring::Port;

/// An instance of the component with the index `k` for itself, with the system's parameter values,
/// then `settings`.
pub fn instantiate(system: &System, k: usize, settings: &[Setting]) -> Result<Instance> {
    make(
        system,
        k,
        settings,
        false,
        system.structure.start_time,
        None,
    )
}

/// The same for a run from `start`, s, maybe in the thread of a worker; `is_staged` as in
/// [`Instance::new`].
pub(crate) fn make(
    system: &System,
    k: usize,
    settings: &[Setting],
    is_staged: bool,
    start: f64,
    worker: Option<&Worker>,
) -> Result<Instance> {
    let component = &system.structure.components[k];
    let fmu = &system.fmus[k];
    let spare = match worker {
        None => spare::take(fmu, &component.name, is_staged),
        Some(_) => None,
    };
    let instance = match spare {
        Some(instance) => instance,
        None => Instance::at(worker, fmu, &component.name, is_staged)?,
    };
    instance.call(Call::SetUp(start), At::Initialization)?;
    for p in &component.parameters {
        instance
            .set_from_text(&p.name, &p.value)
            .with_context(|| p.origin.clone())?;
    }
    for s in settings.iter().filter(|s| s.port.component == k) {
        instance.set_from_text(&system.variable(s.port).name, &s.value)?;
    }
    Ok(instance)
}

/// Value that a variable has in initialization mode under the system's parameter values and
/// `settings`, before any connection is passed.
pub fn start_value(system: &System, settings: &[Setting], port: Port) -> Result<f64> {
    let instance = instantiate(system, port.component, settings)?;
    instance.enter_initialization(system.structure.start_time)?;
    instance.number(port.variable, At::Initialization)
}
