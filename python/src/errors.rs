//! How errors reach Python.

use pyo3::prelude::*;

pyo3::create_exception!(
    hdrm_fmu,
    RunFailed,
    pyo3::exceptions::PyException,
    "A run that failed: what the master says of it, with the texts that the FMUs logged."
);

/// An error of the native code as a Python exception; one that came from Python stays what it was.
pub(crate) fn raised(error: anyhow::Error) -> PyErr {
    match error.downcast::<PyErr>() {
        Ok(error) => error,
        Err(error) => RunFailed::new_err(format!("{error:#}")),
    }
}
