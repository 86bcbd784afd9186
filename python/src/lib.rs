//! The native part of the Python package `hdrm_fmu`: a loaded system ([`system`]), whole runs
//! ([`run`]) with their metrics ([`metrics`]), a run that a script steps ([`session`]), path files
//! ([`inputs`]), and machine files with what is told of them ([`machines`]).
//!
//! Users call the Python package around it, which checks names and values before it calls this
//! module. The interpreter's lock is released while FMUs are loaded, run or stepped.
#![forbid(unsafe_code)]

mod errors;
mod inputs;
mod machines;
mod metrics;
mod run;
mod session;
mod system;

use pyo3::prelude::*;

/// Has the runs of this thread reset the instances of the run before instead of making new ones.
#[pyfunction]
fn reuse_instances() {
    cosim::run::instance_cache::enable_in_this_thread();
}

/// Number of instances that this thread keeps.
#[pyfunction]
fn kept_instances() -> usize {
    cosim::run::instance_cache::count()
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let failed = module.py().get_type::<errors::RunFailed>();
    failed.setattr("result", None::<f64>)?;
    failed.setattr("time", None::<f64>)?;
    module.add("RunFailed", failed)?;
    module.add("WrongThread", module.py().get_type::<errors::WrongThread>())?;
    module.add("MODES", experiments::setup::start_values::MODES.to_vec())?;
    module.add("REAL_SYSTEM", experiments::worlds::SYSTEM)?;
    module.add("REAL_PARAMETERS", experiments::worlds::PARAMETERS)?;
    module.add(
        "MACHINES",
        machine_file::PRESETS.map(|(name, _)| name).to_vec(),
    )?;
    module.add("VERSION", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<system::System>()?;
    module.add_class::<system::DrawnMachine>()?;
    module.add_class::<session::Session>()?;
    module.add_class::<session::Port>()?;
    module.add_class::<session::SavedState>()?;
    module.add_function(wrap_pyfunction!(session::was_forked, module)?)?;
    module.add_function(wrap_pyfunction!(reuse_instances, module)?)?;
    module.add_function(wrap_pyfunction!(kept_instances, module)?)?;
    module.add("BUILT_IN_PATHS", tip_path::BUILT_IN.to_vec())?;
    module.add_function(wrap_pyfunction!(machines::whole_machine, module)?)?;
    module.add_function(wrap_pyfunction!(machines::shipped_machine, module)?)?;
    module.add_function(wrap_pyfunction!(machines::ruled_gains, module)?)?;
    module.add_function(wrap_pyfunction!(machines::check_machine, module)?)?;
    module.add_function(wrap_pyfunction!(machines::scaled_machine, module)?)?;
    module.add_function(wrap_pyfunction!(machines::perturbed_machine, module)?)?;
    module.add_function(wrap_pyfunction!(machines::load_chart, module)?)?;
    module.add_function(wrap_pyfunction!(machines::draw_machine, module)?)?;
    module.add_function(wrap_pyfunction!(machines::sizing_of, module)?)?;
    module.add_function(wrap_pyfunction!(machines::path_check, module)?)?;
    module.add_function(wrap_pyfunction!(inputs::is_built_in_path, module)?)?;
    module.add_function(wrap_pyfunction!(inputs::path_has_loads, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::metric_names, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::tip_error, module)?)
}
