//! Errors of the native code as Python exceptions.

use pyo3::prelude::*;

pyo3::create_exception!(
    hdrm_fmu,
    RunFailed,
    pyo3::exceptions::PyException,
    "A run that failed: the master's message, with the texts that the FMUs logged."
);

/// The Python exception for an error; an exception that came from Python stays the same.
pub(crate) fn to_exception(error: impl Into<anyhow::Error>) -> PyErr {
    match error.into().downcast::<PyErr>() {
        Ok(error) => error,
        Err(error) => RunFailed::new_err(format!("{error:#}")),
    }
}
