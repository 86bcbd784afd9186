//! Makes instances of components with their start values, for the master, probing and studies.

use std::collections::BTreeSet;

use anyhow::{Context, Result};
use fmi_description::Kind;

use crate::instance::workers::Worker;
use crate::instance::{At, Call, Instance};
use crate::run::instance_cache;
use crate::structure::system::{Setting, System};
use crate::wiring::Port;
use fmi_import::raw::Experiment as FmiExperiment;

/// An instance of component `k` on its own, with the system's parameter values, then `settings`.
pub fn instantiate(system: &System, k: usize, settings: &[Setting]) -> Result<Instance> {
    let told = FmiExperiment::from_start(system.structure.start_time);
    make(
        system,
        k,
        settings,
        (false, true),
        told,
        None,
        &BTreeSet::new(),
    )
}

/// The same for a run of which the FMU is `told` this, with its own tolerance where none is given,
/// in a worker's thread if there is one; `is_staged` as in [`Instance::new`]. If a component that ends a
/// step early ends that of all (`stops_all`), one whose clocks are connected may. The variables
/// `nonfinite` may have values that are not finite.
pub(crate) fn make(
    system: &System,
    k: usize,
    settings: &[Setting],
    (is_staged, stops_all): (bool, bool),
    mut told: FmiExperiment,
    worker: Option<&Worker>,
    nonfinite: &BTreeSet<Port>,
) -> Result<Instance> {
    let (component, fmu) = (&system.structure.components[k], &system.fmus[k]);
    let cached = worker
        .is_none()
        .then(|| instance_cache::take(fmu, &component.name, is_staged));
    let mut instance = match cached.flatten() {
        Some(instance) => instance,
        None => {
            // Its ticks would be between the communication points of the others.
            let ticks_others = !stops_all
                && system.structure.connections.iter().any(|c| {
                    let clock = fmu.description.variable(&c.start.1);
                    c.start.0 == component.name && clock.is_ok_and(|v| v.kind == Kind::Clock)
                });
            Instance::in_thread(worker, fmu, &component.name, is_staged, !ticks_others)?
        }
    };
    let [first, next] = [k, k + 1].map(|component| Port::new(component, 0));
    let unchecked = nonfinite.range(first..next).map(|port| port.variable);
    instance.allow_nonfinite(unchecked.collect());
    let own = fmu.description.default_experiment.tolerance;
    if let (false, Some(tolerance)) = (told.has_tolerance, own.filter(|own| *own > 0.0)) {
        (told.has_tolerance, told.tolerance) = (true, tolerance);
    }
    instance.call(Call::SetUp(told), At::Initialization)?;
    let bound = component.parameters.iter();
    let bound = bound.map(|p| (&p.name, &p.value, Some(&p.origin)));
    let own = settings.iter().filter(|s| s.port.component == k);
    let own = own.map(|s| (&system.variable(s.port).name, &s.value, None));
    let values: Vec<_> = bound.chain(own).collect();
    if !fmu.resized.is_empty() {
        let given = values
            .iter()
            .filter_map(|(name, ..)| fmu.description.index(name));
        instance.read_resized(&given.collect())?;
    }
    for (place, (name, value, origin)) in values.iter().enumerate() {
        // A structural parameter has its last value already.
        if fmu.is_structural(name) && values[place + 1..].iter().any(|later| later.0 == *name) {
            continue;
        }
        let set = instance.set_from_text(name, value);
        match origin {
            Some(origin) => set.with_context(|| origin.to_string())?,
            None => set?,
        }
    }
    Ok(instance)
}

/// Value of a variable in Initialization Mode, with the system's parameter values and `settings`,
/// before any connection is passed.
pub fn start_value(system: &System, settings: &[Setting], port: Port) -> Result<f64> {
    let instance = instantiate(system, port.component, settings)?;
    instance.enter_initialization(system.structure.start_time)?;
    instance.number(port.variable, At::Initialization)
}
