//! A whole run for `System.run`, and its results as Python objects: columns, metrics, verdict.

use std::time::{Duration, Instant};

use anyhow::{Error, Result};
use cosim::io::csv::stride;
use cosim::run::interrupt::Interrupted;
use cosim::run::observer::Observer;
use cosim::run::signals::note_locals;
use cosim::run::simulate::{self, Plan};
use cosim::{Experiment, Master, Port, Recording, System, Verdict};
use experiments::measures::metrics::{Metrics, add_residuals, tip_metrics};
use experiments::measures::run::{FailedRun, run as run_machine};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use crate::errors::to_exception;
use crate::metrics::ExtraMetrics;

/// Computing time after which a run checks for Ctrl-C.
pub const INTERRUPT_EVERY: Duration = Duration::from_millis(50);

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

/// The results of a run, or of one that failed up to there.
pub struct RunResult {
    pub recording: Recording,
    pub ports: Vec<Port>,
    pub metrics: Metrics,
    pub verdict: Verdict,
    /// Simulated time and computing time, s.
    pub simulated: f64,
    pub elapsed: f64,
}

/// Records a run, and ends it on Ctrl-C or another signal whose handler raises an exception.
struct Observed {
    recording: Recording,
    extra: Option<ExtraMetrics>,
    /// Communication points between two recorded ones.
    stride: u64,
    checked: Instant,
    /// The exception of the handler.
    raised: Option<PyErr>,
}

impl Observer for Observed {
    fn observe(&mut self, master: &Master) -> Result<()> {
        if master.steps().is_multiple_of(self.stride) {
            self.recording.add(master)?;
        }
        if let Some(extra) = &mut self.extra {
            extra.recording.add(master)?;
        }
        if self.checked.elapsed() > INTERRUPT_EVERY {
            self.checked = Instant::now();
            if let Err(raised) = Python::attach(|py| py.check_signals()) {
                self.raised = Some(raised);
                let (signal, time) = (2, Some(master.time()));
                return Err(Interrupted { signal, time }.into());
            }
        }
        Ok(())
    }

    fn end(&mut self, master: &Master) -> Result<()> {
        match self.recording.times.last() == Some(&master.time()) {
            true => Ok(()),
            false => self.recording.add(master),
        }
    }
}

/// Runs `experiment`; `is_machine` says that it is the manipulator with its controller, whose
/// limits and tip error are then monitored. `progress` is called with the numbers of finished and
/// of all steps. Of a run that fails the second result is the error.
pub fn run(
    system: &System,
    experiment: &Experiment,
    request: &Request,
    is_machine: bool,
    progress: Option<&Py<PyAny>>,
) -> Result<(RunResult, Option<Error>)> {
    let ports = request.signals.iter().map(|name| system.port(name));
    let ports: Vec<Port> = ports.collect::<Result<_>>()?;
    let observed = &mut Observed {
        recording: Recording::new(system, &ports)?,
        extra: ExtraMetrics::new(system, experiment, &request.metrics)?,
        stride: stride(request.interval, experiment.stepping.step)?,
        checked: Instant::now(),
        raised: None,
    };
    let progress = |done: u64, all: u64| {
        if let Some(call) = progress {
            // An exception while showing progress does not end the run.
            Python::attach(|py| drop(call.call1(py, (done, all))));
        }
    };
    let clock = Instant::now();
    let done = complete(system, experiment, request, is_machine, &progress, observed);
    if let Some(raised) = observed.raised.take() {
        return Err(raised.into());
    }
    let recording = &observed.recording;
    let (outcome, metrics, mut verdict, error) = match done {
        Ok((outcome, metrics, verdict)) => (Some(outcome), metrics, verdict, None),
        Err(error) if recording.times.is_empty() => return Err(error),
        Err(error) => {
            let mut verdict = Verdict::default();
            verdict.object(format!("{error:#}"));
            (None, Metrics::new(), verdict, Some(error))
        }
    };
    if !is_machine {
        note_locals(system, &ports, &mut verdict);
    }
    let last = recording.times.last().copied().unwrap_or_default();
    let (simulated, elapsed) = outcome.map_or(
        (last - experiment.stepping.start, clock.elapsed()),
        |outcome| (outcome.simulated, outcome.elapsed),
    );
    let recording = std::mem::replace(&mut observed.recording, Recording::new(system, &[])?);
    let result = RunResult {
        recording,
        ports,
        metrics,
        verdict,
        simulated,
        elapsed: elapsed.as_secs_f64(),
    };
    Ok((result, error))
}

/// Runs to the end; outcome, metrics and all findings.
fn complete(
    system: &System,
    experiment: &Experiment,
    request: &Request,
    is_machine: bool,
    progress: &dyn Fn(u64, u64),
    observed: &mut Observed,
) -> Result<(simulate::Outcome, Metrics, Verdict)> {
    if !is_machine {
        let stop = experiment.stop(system)?;
        let master = experiment.start_until(system, Some(stop))?;
        let plan = Plan::to(stop);
        let outcome = simulate::run_plan(system, master, &plan, progress, observed)?;
        let mut metrics = Metrics::new();
        add_residuals(&mut metrics, &outcome.residuals);
        let verdict = outcome.verdict.clone();
        return Ok((outcome, metrics, verdict));
    }
    let outcome = run_machine(system, experiment, progress, observed);
    let outcome = outcome.map_err(FailedRun::explain)?;
    let mut verdict = outcome.verdict();
    verdict.extend(outcome.tip.verdict(request.max_error));
    let mut metrics = tip_metrics(&outcome.tip);
    add_residuals(&mut metrics, &outcome.run.residuals);
    if let Some(extra) = observed.extra.take() {
        extra.finish(system, &outcome, &mut metrics)?;
    }
    Ok((outcome.run, metrics, verdict))
}

impl RunResult {
    /// Time of the last row, s.
    pub fn last_time(&self) -> f64 {
        self.recording.times.last().copied().unwrap_or(f64::NAN)
    }

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
        let findings = verdict.findings().iter();
        let findings: Vec<_> = findings.map(|f| (f.is_bad, f.text.clone())).collect();
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
pub fn bytes_of_numbers<'py>(py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyByteArray>> {
    PyByteArray::new_with(py, 8 * values.len(), |bytes| {
        for (to, value) in bytes.chunks_exact_mut(8).zip(values) {
            to.copy_from_slice(&value.to_ne_bytes());
        }
        Ok(())
    })
}
