//! What a run is in numbers, by the definitions of `experiments`.

use std::collections::BTreeMap;

use anyhow::Result;
use cosim::{Experiment, Port, Recording, System};
use experiments::measures::energy;
use experiments::measures::metrics::{Metrics, add_energy, add_tracking, tip_metrics};
use experiments::measures::run::{Outcome, RecordedRun, TipError};
use experiments::measures::tracking::Evaluation;
use pyo3::prelude::*;

/// Metrics beside those of the tip error; they take time, because signals are recorded at every
/// communication point.
pub struct Extra {
    tracking: Option<Evaluation>,
    energy: bool,
    recording: Recording,
}

impl Extra {
    /// Those named, of runs of `experiment`; None where none is.
    pub fn new(system: &System, experiment: &Experiment, names: &[String]) -> Result<Option<Self>> {
        let is_asked = |name: &str| names.iter().any(|n| n == name);
        let (tracking, energy) = (is_asked("tracking"), is_asked("energy"));
        if !tracking && !energy {
            return Ok(None);
        }
        let evaluation = tracking.then(|| Evaluation::new(system, experiment));
        let evaluation = evaluation.transpose()?;
        let mut ports: Vec<Port> = evaluation.iter().flat_map(Evaluation::ports).collect();
        if energy {
            ports.extend(energy::ports(system)?);
        }
        Ok(Some(Self {
            tracking: evaluation,
            energy,
            recording: Recording::new(system, &ports)?,
        }))
    }

    /// What is recorded for them, at every communication point.
    pub fn recording(&mut self) -> &mut Recording {
        &mut self.recording
    }

    /// Evaluate the run.
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

/// Names of all metrics of a system with these actuators, each with what a run must be asked for to
/// have it.
#[pyfunction]
pub fn metric_names(actuators: Vec<String>) -> BTreeMap<String, &'static str> {
    experiments::measures::metrics::names(&actuators)
}

/// The metrics of tip errors (m) at times (s), with the motion from `motion_start`, s, on: as those
/// of a run.
#[pyfunction]
pub fn tip_error(times: Vec<f64>, errors: Vec<f64>, motion_start: f64) -> Metrics {
    let mut tip = TipError::new(motion_start);
    for (t, error) in times.into_iter().zip(errors) {
        tip.add(t, error);
    }
    tip_metrics(&tip)
}
