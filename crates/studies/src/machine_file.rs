//! The machine file that an FMU runs with.

use std::path::PathBuf;

use anyhow::{Context, Result};
use cosim::system::{Setting, System};
use cosim::wiring::Port;
use machine::Machine;
use percent_encoding::percent_decode_str;
use sha2::{Digest, Sha256};

/// The machine file that an FMU runs with.
pub struct MachineFile {
    /// Name of the file.
    pub name: String,
    /// SHA-256 of its text.
    pub sha256: String,
    /// What it says.
    pub machine: Machine,
}

impl MachineFile {
    /// The file named by a start value of the manipulator's `machine_file`, of a parameter set or of the system, else the one among the FMU's resources, else the reference.
    pub fn of(system: &System, settings: &[Setting]) -> Result<Self> {
        Self::at(system, settings, system.port("hdrm.machine_file")?)
    }

    /// As [`MachineFile::of`], of the component whose parameter `file` is.
    pub fn at(system: &System, settings: &[Setting], file: Port) -> Result<Self> {
        let component = &system.structure.components[file.component];
        let name = &system.variable(file).name;
        let bound = component.parameters.iter().rev().find(|p| p.name == *name);
        let set = settings.iter().rev().find(|s| s.port == file);
        let set = (set.map(|s| &s.value)).or(bound.map(|p| &p.value));
        let resources = system.fmus[file.component]
            .resources
            .trim_start_matches("file://");
        let resources = PathBuf::from(percent_decode_str(resources).decode_utf8()?.as_ref());
        let mut file = match set {
            Some(value) => PathBuf::from(value),
            None => resources.join("reference_machine.json"),
        };
        if file.is_relative() && !file.exists() {
            file = resources.join(file);
        }
        let text = if set.is_none() && !file.exists() {
            machine::REFERENCE_JSON.into()
        } else {
            std::fs::read_to_string(&file).with_context(|| file.display().to_string())?
        };
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let digest = Sha256::digest(&text);
        Ok(Self {
            name: name.into_owned(),
            sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
            machine: Machine::from_json(&text).with_context(|| file.display().to_string())?,
        })
    }
}
