//! Checks machine and path files before a run, and computes gains by rule, for `hdrm_fmu`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use experiments::setup::loads;
use experiments::worlds::parameter_set_of;
use machine_file::Source;
use motion_check::gain_rule::gains;
use pyo3::prelude::*;
use tip_path::PathFile;

use crate::errors::to_exception;

/// The checked text of a machine file with all that it extends, and the machine's parameter set for
/// the real world; relative paths in the text start at the folder of `file`.
#[pyfunction]
#[pyo3(signature = (text, file=None))]
pub fn whole_machine(text: &str, file: Option<PathBuf>) -> PyResult<(String, &'static str)> {
    let source = Source::read(text, file.as_deref()).map_err(to_exception)?;
    let whole = serde_json::to_string(&source.machine).map_err(to_exception)?;
    Ok((whole, parameter_set_of(source.shipped())))
}

/// The gains by the rule of `hdrm-fmu machine gains`, for actuators as built, of the machine with
/// this checked text.
#[pyfunction]
pub fn ruled_gains(text: &str) -> PyResult<BTreeMap<&'static str, f64>> {
    let source = Source::read(text, None).map_err(to_exception)?;
    let gains = gains(&source.machine).map_err(to_exception)?;
    Ok(gains.iter().map(|gain| (gain.name, gain.value)).collect())
}

/// The text of a shipped machine file.
#[pyfunction]
pub fn shipped_machine(name: &str) -> Option<&'static str> {
    machine_file::preset(name)
}

/// Whether a path of this name is built in.
#[pyfunction]
pub fn is_built_in_path(name: &str) -> PyResult<bool> {
    let path = PathFile::built_in(name).transpose();
    Ok(path.map_err(to_exception)?.is_some())
}

/// Checks the text of a path file; returns whether loads are picked up or set down on the path.
#[pyfunction]
pub fn path_has_loads(text: &str) -> PyResult<bool> {
    let path = PathFile::parse(text).map_err(to_exception)?;
    Ok(loads::has_loads(&path))
}
