//! The metrics of a run, which crate `experiments` defines, for `run` and for the Python package.

use std::collections::BTreeMap;

use anyhow::Result;
use cosim::{Experiment, Port, Recording, System};
use experiments::measures::energy;
use experiments::measures::metrics::{Metrics, add_energy, add_tracking, tip_metrics};
use experiments::measures::run::{Outcome, RecordedRun, TipError};
use experiments::measures::tracking::Evaluation;
use pyo3::prelude::*;

/// Metrics besides those of the tip error. They take time, because signals are recorded at every
/// communication point.
pub struct ExtraMetrics {
    tracking: Option<Evaluation>,
    energy: bool,
    /// Takes every communication point of the run.
    pub recording: Recording,
}

impl ExtraMetrics {
    /// The metrics named, for a run of `experiment`; None if no name is one of them.
    pub fn new(system: &System, experiment: &Experiment, names: &[String]) -> Result<Option<Self>> {
        let is_named = |name: &str| names.iter().any(|n| n == name);
        let (tracking, energy) = (is_named("tracking"), is_named("energy"));
        if !tracking && !energy {
            return Ok(None);
        }
        let tracking = tracking.then(|| Evaluation::new(system, experiment));
        let tracking = tracking.transpose()?;
        let mut ports: Vec<Port> = tracking.iter().flat_map(Evaluation::ports).collect();
        if energy {
            ports.extend(energy::ports(system)?);
        }
        Ok(Some(Self {
            tracking,
            energy,
            recording: Recording::new(system, &ports)?,
        }))
    }

    /// Evaluates the run, and adds the metrics to `metrics`.
    pub fn finish(self, system: &System, outcome: &Outcome, metrics: &mut Metrics) -> Result<()> {
        let recorded = RecordedRun {
            recording: self.recording,
            outcome: outcome.clone(),
        };
        if let Some(evaluation) = &self.tracking {
            let motion_start = outcome.tip.motion_start;
            let tracking = evaluation.evaluate(&recorded.recording, motion_start)?;
            add_tracking(metrics, &tracking);
        }
        if self.energy {
            for balance in energy::evaluate(system, &recorded)?.balances {
                add_energy(metrics, &balance);
            }
        }
        Ok(())
    }
}

/// Names of all metrics of a system with these actuators, each with the value of the option
/// `metrics` that it needs.
#[pyfunction]
pub fn metric_names(actuators: Vec<String>) -> BTreeMap<String, &'static str> {
    experiments::measures::metrics::names(&actuators)
}

/// The metrics of tip errors (m) at times (s), as a run gives them; the motion begins at
/// `motion_start`, s.
#[pyfunction]
pub fn tip_error(times: Vec<f64>, errors: Vec<f64>, motion_start: f64) -> Metrics {
    let mut tip = TipError::new(motion_start);
    for (t, error) in times.into_iter().zip(errors) {
        tip.add(t, error);
    }
    tip_metrics(&tip)
}
