//! A whole run for `System.run`, and its results as Python objects: columns, metrics, verdict.

use anyhow::Result;
use cosim::io::csv::stride;
use cosim::run::signals::note_locals;
use cosim::run::simulate;
use cosim::{Experiment, Master, Port, Recording, System, Verdict};
use experiments::measures::metrics::{Metrics, add_residuals, tip_metrics};
use experiments::measures::run::{FailedRun, run as run_machine};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use crate::errors::to_exception;
use crate::metrics::ExtraMetrics;

/// Number of communication points after which the run checks for Ctrl-C.
const INTERRUPT_EVERY: u64 = 2048;

/// The results that a run is to have.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Request {
    /// Signals that are recorded.
    signals: Vec<String>,
    /// Time between two recorded points, s.
    interval: Option<f64>,
    /// Largest tip error with which the verdict is good, m.
    max_error: Option<f64>,
    /// Names of further metrics.
    metrics: Vec<String>,
}

/// The results of a run.
pub struct RunResult {
    recording: Recording,
    ports: Vec<Port>,
    metrics: Metrics,
    verdict: Verdict,
    simulated: f64,
    elapsed: f64,
}

/// Runs `experiment`; `is_machine` says that it is the manipulator with its controller, whose
/// limits and tip error are then monitored. `progress` is called with the numbers of finished and
/// of all steps.
pub fn run(
    system: &System,
    experiment: &Experiment,
    request: &Request,
    is_machine: bool,
    progress: Option<&Py<PyAny>>,
) -> Result<RunResult> {
    let ports = request.signals.iter().map(|name| system.port(name));
    let ports: Vec<Port> = ports.collect::<Result<_>>()?;
    let stride = stride(request.interval, experiment.stepping.step)?;
    let mut recording = Recording::new(system, &ports)?;
    let mut extra = ExtraMetrics::new(system, experiment, &request.metrics)?;
    let progress = |done: u64, all: u64| {
        if let Some(call) = progress {
            // An exception while showing progress does not end the run.
            Python::attach(|py| drop(call.call1(py, (done, all))));
        }
    };
    let observe = |master: &Master| {
        let steps = master.steps();
        if steps.is_multiple_of(stride) {
            recording.add(master)?;
        }
        if let Some(extra) = &mut extra {
            extra.recording.add(master)?;
        }
        if steps.is_multiple_of(INTERRUPT_EVERY) {
            Python::attach(|py| py.check_signals())?;
        }
        Ok(())
    };
    let (outcome, metrics, verdict) = if is_machine {
        let outcome = run_machine(system, experiment, &progress, observe);
        let outcome = outcome.map_err(FailedRun::explain)?;
        let mut verdict = outcome.limits.clone();
        verdict.extend(outcome.tip.verdict(request.max_error));
        let mut metrics = tip_metrics(&outcome.tip);
        add_residuals(&mut metrics, &outcome.run.residuals);
        if let Some(extra) = extra {
            extra.finish(system, &outcome, &mut metrics)?;
        }
        (outcome.run, metrics, verdict)
    } else {
        let stop = experiment.stop(system)?;
        let master = experiment.start_until(system, Some(stop))?;
        let outcome = simulate::run(system, master, stop, &progress, observe)?;
        let mut metrics = Metrics::new();
        add_residuals(&mut metrics, &outcome.residuals);
        let mut verdict = Verdict::default();
        note_locals(system, &ports, &mut verdict);
        (outcome, metrics, verdict)
    };
    let mut all = outcome.verdict;
    all.extend(verdict);
    Ok(RunResult {
        recording,
        ports,
        metrics,
        verdict: all,
        simulated: outcome.simulated,
        elapsed: outcome.elapsed.as_secs_f64(),
    })
}

impl RunResult {
    /// The results as a dictionary; `verdict` holds the findings from before the run.
    pub fn into_python(
        self,
        py: Python<'_>,
        system: &System,
        mut verdict: Verdict,
    ) -> PyResult<Py<PyDict>> {
        verdict.extend(self.verdict);
        let columns = PyDict::new(py);
        for port in &self.ports {
            let values = self.recording.column(*port).map_err(to_exception)?;
            columns.set_item(system.name(*port), bytes_of_numbers(py, values)?)?;
        }
        let findings: Vec<(bool, String)> = verdict
            .findings()
            .iter()
            .map(|f| (f.is_bad, f.text.clone()))
            .collect();
        let result = PyDict::new(py);
        result.set_item("time", bytes_of_numbers(py, &self.recording.times)?)?;
        result.set_item("columns", columns)?;
        result.set_item("metrics", self.metrics)?;
        result.set_item("is_bad", verdict.is_bad())?;
        result.set_item("findings", findings)?;
        result.set_item("simulated", self.simulated)?;
        result.set_item("elapsed", self.elapsed)?;
        Ok(result.unbind())
    }
}

/// The bytes of numbers, which NumPy reads without a copy.
fn bytes_of_numbers<'py>(py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyByteArray>> {
    PyByteArray::new_with(py, 8 * values.len(), |bytes| {
        for (to, value) in bytes.chunks_exact_mut(8).zip(values) {
            to.copy_from_slice(&value.to_ne_bytes());
        }
        Ok(())
    })
}
