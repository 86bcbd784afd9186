//! Start values that an analysis, a command or the report varies (control law, trajectory, …). A
//! value that the user already sets is refused, and so is one that the system binds, unless the
//! analysis replaces such values: one of the two would have no effect.

use std::fmt::Display;
use std::path::Path;

use anyhow::{Result, bail};
use cosim::{Experiment, Port, Setting, System};
use tip_path::PathFile;

/// Modes of the controller.
pub const MODES: [&str; 8] = [
    "adaptive",
    "adaptive_integral",
    "modular",
    "modular_integral",
    "pd_gravity",
    "pd_gravity_integral",
    "pd",
    "pd_integral",
];
/// The controller's trajectory under commanded rates, which are zero unless they are set.
pub(crate) const BY_RATES: &str = "rates";
/// Trajectories of the controller that need no path.
const OWN_TRAJECTORIES: [&str; 4] = ["cubic", "triangular", "external", BY_RATES];
/// Controller mode that is shipped for the real world; its analyses start from it.
pub const SHIPPED: &str = "adaptive_integral";

/// `base` with start values that an analysis varies; fails if `base` or the system sets one.
pub fn vary(
    system: &System,
    base: &Experiment,
    values: &[(&str, &dyn Display)],
) -> Result<Experiment> {
    let settings = values.iter().map(|(name, v)| system.setting(name, v));
    let settings = settings.collect::<Result<Vec<_>>>()?;
    refuse_bound(system, &settings)?;
    add_settings(system, base, settings)
}

/// Fails if the system itself binds one of the variables.
pub(crate) fn refuse_bound(system: &System, settings: &[Setting]) -> Result<()> {
    for Setting { port, .. } in settings {
        let variable = &system.variable(*port).name;
        let component = &system.structure.components[port.component];
        if let Some(bound) = component.parameters.iter().find(|p| p.name == *variable) {
            bail!(conflict(system, *port, &bound.origin));
        }
    }
    Ok(())
}

/// `base` with start values that may replace what the system binds; fails if `base` sets one.
pub fn add_settings(
    system: &System,
    base: &Experiment,
    settings: Vec<Setting>,
) -> Result<Experiment> {
    for Setting { port, .. } in &settings {
        if let Some(set) = base.settings.iter().find(|s| s.port == *port) {
            let is_path = system.variable(*port).name == "trajectory" && set.value == "path";
            let origin = if is_path {
                "--waypoints or --set"
            } else {
                "--set"
            };
            bail!(conflict(system, *port, origin));
        }
    }
    let mut experiment = base.clone();
    experiment.settings.extend(settings);
    Ok(experiment)
}

fn conflict(system: &System, port: Port, origin: &str) -> String {
    let name = system.name(port);
    format!("`{name}` is set ({origin}), but this command varies it itself, so it must not be set")
}

/// Whether `trajectory` is a built-in path or a file, and not one of the controller's own.
pub(crate) fn is_path(trajectory: &str) -> bool {
    let is_file = PathFile::built_in(trajectory).is_some() || Path::new(trajectory).is_file();
    is_file && !OWN_TRAJECTORIES.contains(&trajectory)
}

/// The start values with which the controller follows one of its trajectories, or a path.
pub fn trajectory_settings(system: &System, trajectory: &str) -> Result<Vec<Setting>> {
    if is_path(trajectory) {
        return path_settings(system, trajectory);
    }
    Ok(vec![system.setting("trajectory", trajectory)?])
}

/// The start values with which the controller follows a path file or a built-in path.
pub(crate) fn path_settings(system: &System, path: &str) -> Result<Vec<Setting>> {
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

/// A control law: a controller mode and the start values that go with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Law {
    /// Name in the tables.
    pub name: String,
    /// Variables and start values; the controller's, or named with their component.
    pub values: Vec<(String, String)>,
}

impl Law {
    /// The controller mode `mode` under a name of its own.
    pub fn new(name: impl Into<String>, mode: &str) -> Self {
        Self {
            name: name.into(),
            values: vec![("mode".into(), mode.into())],
        }
    }

    /// The law with one more start value.
    #[must_use]
    pub fn with(mut self, variable: &str, value: impl ToString) -> Self {
        self.values.push((variable.into(), value.to_string()));
        self
    }

    /// The start values as settings of `system`.
    pub fn settings(&self, system: &System) -> Result<Vec<Setting>> {
        let controller = system.port("desired.position[1]")?.component;
        let setting = |(variable, value): &(String, String)| {
            let port = system.port_of(controller, variable);
            let port = port.or_else(|_| system.port(variable))?;
            system.setting(&system.name(port), value)
        };
        self.values.iter().map(setting).collect()
    }

    /// Whether the law has an integral but no adaptation: what adaptive laws are compared with.
    pub fn is_rival_with_integral(&self) -> bool {
        let mode = self.values.iter().find(|(name, _)| name == "mode");
        mode.is_some_and(|(_, v)| v.ends_with("_integral") && !v.starts_with("adaptive"))
    }
}

/// A law for each of these controller modes.
pub fn laws_of_modes(modes: &[&str]) -> Vec<Law> {
    modes.iter().map(|mode| Law::new(*mode, mode)).collect()
}
