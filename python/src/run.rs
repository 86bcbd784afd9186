//! A whole run: signals as columns of numbers, metrics, verdict.

use anyhow::Result;
use cosim::io::csv::stride;
use cosim::run::simulate;
use cosim::{Experiment, Master, Port, Recording, System, Verdict};
use experiments::measures::metrics::{Metrics, add_residuals, tip_metrics};
use experiments::measures::run::{FailedRun, run as run_machine};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use crate::errors::raised;
use crate::metrics::Extra;

/// Communication points between two looks at whether the user has pressed Ctrl-C.
const SIGNALS_EVERY: u64 = 2048;

/// What is to come out of a run.
#[derive(FromPyObject)]
pub struct Request {
    /// Signals that are kept.
    #[pyo3(item)]
    signals: Vec<String>,
    /// Time between two kept points, s.
    #[pyo3(item)]
    interval: Option<f64>,
    /// Largest tip error with which the verdict is good, m.
    #[pyo3(item)]
    max_error: Option<f64>,
    /// Names of further metrics.
    #[pyo3(item)]
    metrics: Vec<String>,
}

/// What came out.
pub struct Done {
    recording: Recording,
    ports: Vec<Port>,
    metrics: Metrics,
    verdict: Verdict,
    simulated: f64,
    elapsed: f64,
}

/// Run `experiment`, of the manipulator with its controller if it `is_machine`, so that its limits
/// and its tip are watched; `progress` is called with the numbers of finished and of all steps.
pub fn run(
    system: &System,
    experiment: &Experiment,
    request: &Request,
    is_machine: bool,
    progress: Option<&Py<PyAny>>,
) -> Result<Done> {
    let ports = request.signals.iter().map(|name| system.port(name));
    let ports: Vec<Port> = ports.collect::<Result<_>>()?;
    let stride = stride(request.interval, experiment.stepping.step)?;
    let mut recording = Recording::new(system, &ports)?;
    let mut extra = Extra::new(system, experiment, &request.metrics)?;
    let progress = |done: u64, all: u64| {
        if let Some(call) = progress {
            // What goes wrong in showing progress does not end a run.
            Python::attach(|py| drop(call.call1(py, (done, all))));
        }
    };
    let observe = |master: &Master| {
        let steps = master.steps();
        if steps.is_multiple_of(stride) {
            recording.add(master)?;
        }
        if let Some(extra) = &mut extra {
            extra.recording().add(master)?;
        }
        if steps.is_multiple_of(SIGNALS_EVERY) {
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
        let master = experiment.start(system)?;
        let stop = experiment.stop(system)?;
        let outcome = simulate::run(system, master, stop, &progress, observe)?;
        let mut metrics = Metrics::new();
        add_residuals(&mut metrics, &outcome.residuals);
        (outcome, metrics, Verdict::default())
    };
    let mut all = outcome.verdict;
    all.extend(verdict);
    Ok(Done {
        recording,
        ports,
        metrics,
        verdict: all,
        simulated: outcome.simulated,
        elapsed: outcome.elapsed.as_secs_f64(),
    })
}

impl Done {
    /// Everything as Python has it; `before` is what was found before the run.
    pub fn into_python(
        self,
        py: Python<'_>,
        system: &System,
        before: Verdict,
    ) -> PyResult<Py<PyDict>> {
        let mut verdict = before;
        verdict.extend(self.verdict);
        let columns = PyDict::new(py);
        for port in &self.ports {
            let values = self.recording.column(*port).map_err(raised)?;
            columns.set_item(system.name(*port), numbers(py, values)?)?;
        }
        let findings: Vec<(bool, String)> = verdict
            .findings()
            .iter()
            .map(|f| (f.is_bad, f.text.clone()))
            .collect();
        let done = PyDict::new(py);
        done.set_item("time", numbers(py, &self.recording.times)?)?;
        done.set_item("columns", columns)?;
        done.set_item("metrics", self.metrics)?;
        done.set_item("is_bad", verdict.is_bad())?;
        done.set_item("findings", findings)?;
        done.set_item("simulated", self.simulated)?;
        done.set_item("elapsed", self.elapsed)?;
        Ok(done.unbind())
    }
}

/// The bytes of numbers, as NumPy reads them without a copy.
fn numbers<'py>(py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyByteArray>> {
    PyByteArray::new_with(py, 8 * values.len(), |bytes| {
        for (to, value) in bytes.chunks_exact_mut(8).zip(values) {
            to.copy_from_slice(&value.to_ne_bytes());
        }
        Ok(())
    })
}
