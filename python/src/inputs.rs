//! Files that a run reads, looked at before it starts: machines and paths.

use std::collections::BTreeMap;
use std::path::PathBuf;

use experiments::setup::loads;
use experiments::worlds::parameter_set_of;
use machine_file::Source;
use motion_check::gain_rule::gains;
use pyo3::prelude::*;
use tip_path::PathFile;

use crate::errors::raised;

/// The checked text of a machine file with all that it extends, and the parameter set of the real
/// world that belongs to the machine; `file` is where its relative paths start.
#[pyfunction]
#[pyo3(signature = (text, file=None))]
pub fn whole_machine(text: &str, file: Option<PathBuf>) -> PyResult<(String, &'static str)> {
    let source = Source::read(text, file.as_deref()).map_err(|error| raised(error.into()))?;
    let whole = serde_json::to_string(&source.machine).map_err(|error| raised(error.into()))?;
    Ok((whole, parameter_set_of(source.shipped())))
}

/// The gains that the rule makes of a machine, whose checked text this is, for actuators as built.
#[pyfunction]
pub fn ruled_gains(text: &str) -> PyResult<BTreeMap<&'static str, f64>> {
    let source = Source::read(text, None).map_err(|error| raised(error.into()))?;
    let gains = gains(&source.machine).map_err(|error| raised(error.into()))?;
    Ok(gains.iter().map(|gain| (gain.name, gain.value)).collect())
}

/// The text of the machine file that the programs know by this name.
#[pyfunction]
pub fn shipped_machine(name: &str) -> Option<&'static str> {
    machine_file::preset(name)
}

/// Whether a path of this name is built in.
#[pyfunction]
pub fn is_built_in_path(name: &str) -> PyResult<bool> {
    let path = PathFile::built_in(name).transpose();
    Ok(path.map_err(|error| raised(error.into()))?.is_some())
}

/// Whether anything is picked up or set down on the path of a file with this text, which is
/// checked.
#[pyfunction]
pub fn path_has_loads(text: &str) -> PyResult<bool> {
    let path = PathFile::parse(text).map_err(|error| raised(error.into()))?;
    Ok(loads::has_loads(&path))
}
