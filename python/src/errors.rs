//! Errors of the native code as Python exceptions, for all functions that Python calls.

use anyhow::Error;
use pyo3::prelude::*;
use pyo3::types::PyDict;

pyo3::create_exception!(
    hdrm_fmu,
    RunFailed,
    pyo3::exceptions::PyException,
    "Any error of the native code: a failed run (the master's message, with what the FMUs logged), or a file that cannot be read. \
     Of a failed run, `result` is what `run` would have returned with the rows until then, and `time` the time of the last row, s."
);

pyo3::create_exception!(
    hdrm_fmu,
    WrongThread,
    pyo3::exceptions::PyRuntimeError,
    "A system that is stepped was used by another thread than the one that started it, or by a process that was forked meanwhile."
);

/// The Python exception for an error; an exception that came from Python stays the same.
pub(crate) fn to_exception(error: impl Into<Error>) -> PyErr {
    match error.into().downcast::<PyErr>() {
        Ok(error) => error,
        Err(error) => RunFailed::new_err(format!("{error:#}")),
    }
}

/// The exception for a run that failed after some rows; an exception that came from Python stays
/// the same.
pub(crate) fn failed_run(py: Python<'_>, error: Error, result: Py<PyDict>, time: f64) -> PyErr {
    let exception = to_exception(error);
    if exception.is_instance_of::<RunFailed>(py) {
        let value = exception.value(py);
        let set = value
            .setattr("result", result)
            .and_then(|()| value.setattr("time", time));
        return set.err().unwrap_or(exception);
    }
    exception
}
