//! Reads the files that String parameters in `table` name: machine, network, path.

use super::model::Parameters;
use emla::Surrogate;
use fmu_export::read_parameter_file;
use std::path::Path;
use tip_path::{BUILT_IN, PathFile};

pub(crate) fn read_machine(
    p: &mut Parameters,
    file: &str,
    resources: Option<&Path>,
) -> Result<(), String> {
    p.machine = actuator_table::machine(file, resources)?;
    p.machine_file = file.to_owned();
    Ok(())
}

pub(crate) fn read_surrogate(
    p: &mut Parameters,
    file: &str,
    resources: Option<&Path>,
) -> Result<(), String> {
    p.surrogate = match file {
        "" => Surrogate::reference(),
        _ => read_parameter_file(file, resources, Surrogate::from_json)?,
    };
    p.surrogate_file = file.to_owned();
    Ok(())
}

pub(crate) fn read_path(
    p: &mut Parameters,
    file: &str,
    resources: Option<&Path>,
) -> Result<(), String> {
    p.path = match PathFile::built_in(file) {
        _ if file.is_empty() => None,
        Some(test) => Some(test.map_err(|e| format!("path `{file}`: {e}"))?),
        None => Some(
            read_parameter_file(file, resources, PathFile::parse).map_err(|e| {
                let is_found =
                    Path::new(file).exists() || resources.is_some_and(|r| r.join(file).exists());
                if is_found {
                    return e;
                }
                format!("{e}; the built-in paths are {}", BUILT_IN.join(" and "))
            })?,
        ),
    };
    p.path_file = file.to_owned();
    Ok(())
}
