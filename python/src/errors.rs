//! Errors of the native code as Python exceptions, for all functions that Python calls.

use pyo3::prelude::*;

pyo3::create_exception!(
    hdrm_fmu,
    RunFailed,
    pyo3::exceptions::PyException,
    "Any error of the native code: a failed run (the master's message, with what the FMUs logged), or a file that cannot be read."
);

/// The Python exception for an error; an exception that came from Python stays the same.
pub(crate) fn to_exception(error: impl Into<anyhow::Error>) -> PyErr {
    match error.into().downcast::<PyErr>() {
        Ok(error) => error,
        Err(error) => RunFailed::new_err(format!("{error:#}")),
    }
}
