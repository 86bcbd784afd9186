//! Start values that a study varies: set on top of those that the user has set, refused where one
//! would not count.

use std::fmt::Display;

use anyhow::{Result, bail};
use cosim::master::Schedule;
use cosim::{Experiment, Port, Setting, System};
use tip_path::{PathFile, SIX_JOINTS};

/// The parameter of controller and actuators that says how many steps late their outputs act.
const DELAY: &str = "delay";

/// `base` with the start values that a study varies.
///
/// # Errors
/// One of them is set in `base` or bound by the system, so that what was set would not count.
pub fn vary(
    system: &System,
    base: &Experiment,
    values: &[(&str, &dyn Display)],
) -> Result<Experiment> {
    let settings = values
        .iter()
        .map(|(name, value)| system.setting(name, value));
    with(system, base, settings.collect::<Result<_>>()?)
}

/// As [`vary`].
pub fn with(system: &System, base: &Experiment, settings: Vec<Setting>) -> Result<Experiment> {
    for Setting { port, .. } in &settings {
        let variable = &system.variable(*port).name;
        let component = &system.structure.components[port.component];
        if let Some(bound) = component.parameters.iter().find(|p| p.name == *variable) {
            bail!(is_varied(system, *port, &bound.origin));
        }
    }
    over(system, base, settings)
}

/// As [`with`], of what the system may bind too.
pub fn over(system: &System, base: &Experiment, settings: Vec<Setting>) -> Result<Experiment> {
    for Setting { port, .. } in &settings {
        if base.settings.iter().any(|s| s.port == *port) {
            bail!(is_varied(system, *port, "--set"));
        }
    }
    let mut experiment = base.clone();
    experiment.settings.extend(settings);
    Ok(experiment)
}

fn is_varied(system: &System, port: Port, origin: &str) -> String {
    let name = system.name(port);
    format!("`{name}` is set ({origin}), but this command varies it itself, so it must not be set")
}

/// The start values with which the controller follows a trajectory.
///
/// # Errors
/// A system without a controller that can.
pub fn following(system: &System, trajectory: &str) -> Result<Vec<Setting>> {
    if trajectory == SIX_JOINTS {
        return on_path(system, trajectory);
    }
    Ok(vec![system.setting("trajectory", trajectory)?])
}

/// The start values with which the controller follows a path.
pub(crate) fn on_path(system: &System, path: &str) -> Result<Vec<Setting>> {
    let controller = system.component_of(system.port("trajectory")?);
    let file = match PathFile::built_in(path) {
        Some(_) => path.to_owned(),
        None => std::path::absolute(path)?.display().to_string(),
    };
    Ok(vec![
        system.setting(&format!("{controller}.trajectory"), "path")?,
        system.setting(&format!("{controller}.path_file"), file)?,
    ])
}

/// Tells all components that have a parameter `delay` that with the schedule `standard` their
/// outputs act one step late. All of them: a controller that predicts over the step needs actuators
/// that do too. What the structure or a parameter set says of a component's delay stays.
pub fn tell_delay(system: &System, base: &mut Experiment) -> Result<()> {
    if base.stepping.schedule != Schedule::Standard {
        return Ok(());
    }
    for (component, element) in system.structure.components.iter().enumerate() {
        let is_bound = element.parameters.iter().any(|p| p.name == DELAY);
        let Ok(delay) = system.port_of(component, DELAY) else {
            continue;
        };
        if !is_bound && !base.settings.iter().any(|s| s.port == delay) {
            base.settings.push(system.setting(&system.name(delay), 1)?);
        }
    }
    Ok(())
}
