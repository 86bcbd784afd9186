//! Start values that an analysis varies, of control laws, trajectories and others: set on top of
//! those that the user has set, refused where one would not count.

use std::fmt::Display;

use anyhow::{Result, bail};
use cosim::{Experiment, Port, Setting, System};
use tip_path::{PathFile, SIX_JOINTS};

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
/// Law that the analyses of the real world start from.
pub const SHIPPED: &str = "adaptive_integral";

/// `base` with the start values that an analysis varies.
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

/// A control law.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Law {
    /// Name in the tables.
    pub name: String,
    /// Variables and their start values; of the controller, or with their component.
    pub values: Vec<(String, String)>,
}

impl Law {
    /// The law `mode` under a name of its own.
    pub fn new(name: impl Into<String>, mode: &str) -> Self {
        Self {
            name: name.into(),
            values: vec![("mode".into(), mode.into())],
        }
    }

    /// The law with one more value.
    #[must_use]
    pub fn with(mut self, variable: &str, value: impl ToString) -> Self {
        self.values.push((variable.into(), value.to_string()));
        self
    }

    /// The start values as settings of the controller of `system`.
    pub fn settings(&self, system: &System) -> Result<Vec<Setting>> {
        let controller = system.port("desired.position[1]")?.component;
        let setting = |(variable, value): &(String, String)| {
            let port = system.port_of(controller, variable);
            let port = port.or_else(|_| system.port(variable))?;
            system.setting(&system.name(port), value)
        };
        self.values.iter().map(setting).collect()
    }

    /// Whether it is a rival of the adaptive ones with an integral of its own.
    pub fn is_rival_with_integral(&self) -> bool {
        let mode = self.values.iter().find(|(name, _)| name == "mode");
        mode.is_some_and(|(_, v)| v.ends_with("_integral") && !v.starts_with("adaptive"))
    }
}

/// The laws of these modes of the controller.
pub fn of_modes(modes: &[&str]) -> Vec<Law> {
    modes.iter().map(|mode| Law::new(*mode, mode)).collect()
}
