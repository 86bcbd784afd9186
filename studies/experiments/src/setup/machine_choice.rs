//! The machine file that an FMU runs with: `--machine` and Python bind one to all FMUs ([`bind`]);
//! commands, analyses, measures and report read that of a component ([`MachineFile`]).

use std::path::PathBuf;

use anyhow::{Context, Result};
use cosim::structure::DataType;
use cosim::{Port, Setting, System};
use machine_file::{AXES, Machine, Source, preset};
use percent_encoding::percent_decode_str;
use surrogate::measurement::data::sha256;

/// Parameter of the FMUs that depend on the machine's dimensions, actuators or gains.
const MACHINE_FILE: &str = "machine_file";

/// Parameter of an actuator that says which of the machine's it is: slew, lift or tilt.
const AXIS: &str = "axis";

/// The machine file that an FMU runs with.
pub struct MachineFile {
    /// Name of the file.
    pub name: String,
    /// SHA-256 of its text and of those that it extends.
    pub sha256: String,
    /// What it says.
    pub machine: Machine,
}

/// Binds `machine`, a file or the name of a shipped machine, to the parameter `machine_file` of
/// every component that has it, in place of what the system binds. Also binds each actuator's
/// `axis`: the one that its name ends in, such as `emla_lift`, else the next in order.
///
/// Fails with everything that is wrong with the machine, or if the manipulator takes no file.
pub fn bind(system: &mut System, machine: &str) -> Result<()> {
    Source::named(machine)?;
    // Another maker's plant may get its dimensions from elsewhere; a testbed has no manipulator.
    if let Ok(plant) = system.port("f_hold[1]") {
        let file = system.port_of(plant.component, MACHINE_FILE);
        file.context("this manipulator takes no machine file")?;
    }
    let mut actuators = 0;
    for (component, fmu) in system.structure.components.iter_mut().zip(&system.fmus) {
        let name = component.name.clone();
        let mut bind = |name: &str, value: String, data_type| {
            component.bind(name, value, data_type, "--machine");
        };
        if fmu.description.index(MACHINE_FILE).is_some() {
            bind(MACHINE_FILE, machine.into(), DataType::String);
        }
        if fmu.description.index(AXIS).is_some() {
            actuators += 1;
            let named = AXES.iter().position(|axis| name.ends_with(axis));
            let axis = named.map_or(actuators, |k| k + 1);
            bind(AXIS, axis.to_string(), DataType::Integer);
        }
    }
    Ok(())
}

impl MachineFile {
    /// The file of the manipulator: named by `settings`, by a parameter set or by the system, else
    /// the one among the FMU's resources, else the reference machine.
    pub fn from_manipulator(system: &System, settings: &[Setting]) -> Result<Self> {
        Self::from_parameter(system, settings, system.port("hdrm.machine_file")?)
    }

    /// As [`MachineFile::from_manipulator`], but `None` if the manipulator takes no file.
    pub fn from_plant(system: &System, settings: &[Setting]) -> Result<Option<Self>> {
        let port = system.port("hdrm.machine_file").ok();
        port.map(|port| Self::from_parameter(system, settings, port))
            .transpose()
    }

    /// As [`MachineFile::from_manipulator`], for the component that has the parameter `file`.
    pub fn from_parameter(system: &System, settings: &[Setting], file: Port) -> Result<Self> {
        let component = &system.structure.components[file.component];
        let name = &system.variable(file).name;
        let bound = component.parameters.iter().rev().find(|p| p.name == *name);
        let set = settings.iter().rev().find(|s| s.port == file);
        let set = set.map(|s| &s.value).or(bound.map(|p| &p.value));
        let set = set.filter(|name| !name.is_empty());
        let resources = system.fmus[file.component]
            .resources()
            .trim_start_matches("file://");
        let resources = PathBuf::from(percent_decode_str(resources).decode_utf8()?.as_ref());
        let mut file = match set {
            Some(value) => PathBuf::from(value),
            None => resources.join("reference_machine.json"),
        };
        if file.is_relative() && !file.exists() {
            file = resources.join(file);
        }
        let shipped = set.and_then(|name| preset(name));
        let text = if let Some(text) = shipped {
            text.into()
        } else if set.is_none() && !file.exists() {
            machine_file::REFERENCE_JSON.into()
        } else {
            output_file::note_read(&file)?;
            std::fs::read_to_string(&file).with_context(|| file.display().to_string())?
        };
        let read = Source::read(&text, shipped.is_none().then_some(&*file));
        let Source { machine, texts } = read.with_context(|| file.display().to_string())?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: name.into_owned(),
            sha256: sha256(texts.concat().as_bytes()),
            machine,
        })
    }
}

/// Reads a machine file, or the shipped machine of this name.
pub fn read(name: &str) -> Result<Machine> {
    output_file::note_read(name.as_ref())?;
    let source = Source::named(name).with_context(|| name.to_owned())?;
    Ok(source.machine)
}
