//! The native part of the Python package `hdrm_fmu`: a loaded system ([`system`]), whole runs ([`run`]) with their metrics
//! ([`metrics`]), and a run that a script steps ([`session`]).
//!
//! What a person reads and calls is the Python package around it, which checks names and values before it calls anything here. The
//! interpreter's lock is released while FMUs are loaded, run or stepped.
#![forbid(unsafe_code)]

mod metrics;
mod run;
mod session;
mod system;

use std::path::PathBuf;

use pyo3::prelude::*;

pyo3::create_exception!(
    hdrm_fmu._native,
    NativeError,
    pyo3::exceptions::PyException,
    "What the native master says of a run that failed, with the texts that the FMUs logged."
);

/// An error of the native code as a Python exception; one that came from Python stays what it was.
pub(crate) fn raised(error: anyhow::Error) -> PyErr {
    match error.downcast::<PyErr>() {
        Ok(error) => error,
        Err(error) => NativeError::new_err(format!("{error:#}")),
    }
}

/// Keep the instances of runs in this thread and use them again, reset, in the next ones.
#[pyfunction]
fn reuse_instances() {
    cosim::spare::reuse_in_this_thread();
}

/// Number of instances that this thread keeps.
#[pyfunction]
fn kept_instances() -> usize {
    cosim::spare::count()
}

/// The checked text of a machine file with all that it extends; `file` is where its relative paths start.
#[pyfunction]
#[pyo3(signature = (text, file=None))]
fn whole_machine(text: &str, file: Option<PathBuf>) -> PyResult<String> {
    let machine = match file {
        Some(file) => machine::Machine::of_file(text, &file),
        None => machine::Machine::from_json(text),
    };
    let machine = machine.map_err(|error| raised(error.into()))?;
    serde_json::to_string(&machine).map_err(|error| raised(error.into()))
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("NativeError", module.py().get_type::<NativeError>())?;
    module.add("MODES", studies::laws::MODES.to_vec())?;
    module.add("REAL_SYSTEM", studies::worlds::SYSTEM)?;
    module.add("REAL_PARAMETERS", studies::worlds::PARAMETERS)?;
    module.add("VERSION", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<system::System>()?;
    module.add_class::<system::Drawn>()?;
    module.add_class::<session::Session>()?;
    module.add_function(wrap_pyfunction!(reuse_instances, module)?)?;
    module.add_function(wrap_pyfunction!(kept_instances, module)?)?;
    module.add_function(wrap_pyfunction!(whole_machine, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::metric_names, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::tip_error, module)?)
}
