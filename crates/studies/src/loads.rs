//! Loads of a path on their way from the controller to the manipulator.
//!
//! The packed systems have no wires for them, so that a plant of another make, which knows of no loads, takes `Hdrm`'s place as it is.

use anyhow::{Result, bail};
use cosim::linear::Linear;
use cosim::ssd::{Connection, Connector};
use cosim::system::System;
use fmu_description::Causality;
use tip_path::{PathFile, Points};

/// What is carried: mass, kg, and place from T4, m; output of the controller, input of the manipulator.
const LOAD: [(&str, &str); 4] = [
    ("load.mass", "kg"),
    ("load.com[1]", "m"),
    ("load.com[2]", "m"),
    ("load.com[3]", "m"),
];

/// Whether anything is picked up or set down on the path.
#[must_use]
pub fn are_on(path: &PathFile) -> bool {
    match &path.points {
        Points::Waypoints(points) => points.iter().any(|point| point.load.is_some()),
        Points::Samples(_) => false,
    }
}

/// Connects the loads of the controller's path to the manipulator, where the system has not done it.
///
/// # Errors
/// A manipulator that takes no loads.
pub fn connect(system: &mut System) -> Result<()> {
    let controller = system.component_of(system.port("trajectory")?).to_string();
    let has = |k: usize, causality| {
        let v = system.fmus[k].description.variable(LOAD[0].0);
        v.is_ok_and(|v| v.causality == causality)
    };
    let components = &system.structure.components;
    let Some(plant) = (0..components.len()).find(|&k| has(k, Causality::Input)) else {
        bail!(
            "the path picks up loads, but no component has the inputs `load.mass` and `load.com[1..3]` that take them"
        );
    };
    let plant = components[plant].name.clone();
    for (name, unit) in LOAD {
        let (start, end) = (
            (controller.clone(), name.into()),
            (plant.clone(), name.into()),
        );
        if system.structure.connections.iter().any(|c| c.end == end) {
            continue;
        }
        for (component, kind) in [(&controller, "output"), (&plant, "input")] {
            declare(system, component, name, kind, unit);
        }
        system.structure.connections.push(Connection {
            start,
            end,
            transformation: Linear::NONE,
            units_stay: false,
            bond: None,
        });
    }
    Ok(())
}

fn declare(system: &mut System, component: &str, name: &str, kind: &str, unit: &str) {
    let mut components = system.structure.components.iter_mut();
    let Some(component) = components.find(|c| c.name == component) else {
        return;
    };
    if component.connectors.iter().all(|c| c.name != name) {
        component.connectors.push(Connector {
            name: name.into(),
            kind: kind.into(),
            data_type: "Real",
            unit: Some(unit.into()),
        });
    }
}
