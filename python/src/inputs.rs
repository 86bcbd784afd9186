//! Checks path files before a run, for `hdrm_fmu`.

use experiments::setup::loads;
use pyo3::prelude::*;
use tip_path::PathFile;

use crate::errors::to_exception;

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
