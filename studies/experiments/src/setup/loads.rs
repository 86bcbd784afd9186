//! Connects the loads that a path picks up (outputs of the controller) to the plant's inputs, for
//! the commands (by `run_setup`) and for Python.
//!
//! The packed systems lack these connections: a plant without inputs for loads can replace `Hdrm`.

use anyhow::{Result, bail};
use cosim::System;
use fmi_description::Causality;
use tip_path::{PathFile, Points};

/// Carried load: mass, kg, and centre of mass in T4, m; outputs of controller, inputs of plant.
const LOAD: [&str; 4] = ["load.mass", "load.com[1]", "load.com[2]", "load.com[3]"];

/// Whether anything is picked up or set down on the path.
pub fn has_loads(path: &PathFile) -> bool {
    match &path.points {
        Points::Waypoints(points) => points.iter().any(|point| point.load.is_some()),
        Points::Samples(_) => false,
    }
}

/// Connects the loads of the controller's path to the manipulator, unless the system does already.
/// Fails if no component takes loads.
pub fn connect(system: &mut System) -> Result<()> {
    let controller = system.component_of(system.port("trajectory")?).to_string();
    let has = |k: usize, causality| {
        let v = system.fmus[k].description.variable(LOAD[0]);
        v.is_ok_and(|v| v.causality == causality)
    };
    let components = &system.structure.components;
    let Some(plant) = (0..components.len()).find(|&k| has(k, Causality::Input)) else {
        bail!(
            "the path picks up loads, but no component has the inputs `load.mass` and `load.com[1..3]` that take them"
        );
    };
    let plant = components[plant].name.clone();
    for name in LOAD {
        let end = (plant.clone(), name.into());
        if !system.structure.connections.iter().any(|c| c.end == end) {
            let start = (controller.clone(), name.into());
            system.structure.connect(start, end);
        }
    }
    Ok(())
}
