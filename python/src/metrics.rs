//! What a run is in numbers, by the definitions of `studies`.

use std::collections::BTreeMap;

use anyhow::Result;
use cosim::recording::Recording;
use cosim::run::Experiment;
use cosim::system::System;
use cosim::wiring::Port;
use pyo3::prelude::*;
use studies::energy;
use studies::experiment::{Outcome, Recorded};
use studies::tip::TipError;
use studies::tracking::{Evaluation, PositionError, Tracking};

/// Numbers by name.
pub type Metrics = BTreeMap<String, f64>;

/// Metrics beside those of the tip error; they take time, because signals are recorded at every communication point.
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
        let recorded = Recorded {
            recording: self.recording,
            outcome: outcome.clone(),
        };
        if let Some(evaluation) = &self.tracking {
            add_tracking(metrics, &evaluation.evaluate(&recorded)?);
        }
        if self.energy {
            for balance in energy::evaluate(system, &recorded)?.balances {
                let of = format!("energy_{}", balance.actuator);
                let efficiency = balance.efficiency().unwrap_or(f64::NAN);
                metrics.insert(format!("{of}_efficiency"), efficiency);
                let values = serde_json::to_value(&balance)?;
                for (name, value) in values.as_object().into_iter().flatten() {
                    if let Some(value) = value.as_f64() {
                        metrics.insert(format!("{of}_{name}"), value);
                    }
                }
            }
        }
        Ok(())
    }
}

fn add_tracking(metrics: &mut Metrics, tracking: &Tracking) {
    let mut position = |of: &str, error: &PositionError| {
        let values = serde_json::to_value(error).unwrap_or_default();
        for (name, value) in values.as_object().into_iter().flatten() {
            metrics.insert(format!("{of}_{name}"), value.as_f64().unwrap_or(f64::NAN));
        }
    };
    position("known", &tracking.known);
    position("joints", &tracking.joints);
    position("plant", &tracking.plant);
    if let Some(bent) = &tracking.bent {
        position("rigid", &bent.rigid);
        metrics.insert("sag_rms".into(), bent.sag_rms);
        metrics.insert("sag_max".into(), bent.sag_max);
    }
    let [rms, max] = tracking.orientation;
    metrics.insert("orientation_rms".into(), rms);
    metrics.insert("orientation_max".into(), max);
    metrics.insert("speed_max".into(), tracking.speed);
    metrics.insert("rho".into(), tracking.rho());
}

/// The tip error and the power residuals of a run.
pub fn of_run(outcome: &Outcome) -> Metrics {
    let mut metrics = of_tip(&outcome.tip);
    add_residuals(&mut metrics, &outcome.run.residuals);
    metrics
}

/// The power residuals of a run: largest peak, and the energy that the coupling made (negative) or lost at all bonds.
pub fn add_residuals(metrics: &mut Metrics, residuals: &[cosim::bond::Residual]) {
    let peak = residuals.iter().map(|r| r.peak).fold(0.0, f64::max);
    metrics.insert("residual_peak".into(), peak);
    let energy = residuals.iter().map(|r| r.energy).sum();
    metrics.insert("residual_energy".into(), energy);
}

fn of_tip(tip: &TipError) -> Metrics {
    let named = [
        ("tip_rmse", tip.motion.rms()),
        ("tip_max", tip.motion.max),
        ("tip_rmse_whole", tip.whole.rms()),
        ("tip_max_whole", tip.whole.max),
        ("motion_start", tip.motion_start),
    ];
    named.map(|(name, value)| (name.to_string(), value)).into()
}

/// The metrics of tip errors (m) at times (s), with the motion from `motion_start`, s, on: as those of a run.
#[pyfunction]
pub fn tip_error(times: Vec<f64>, errors: Vec<f64>, motion_start: f64) -> Metrics {
    let mut tip = TipError::new(motion_start);
    for (t, error) in times.into_iter().zip(errors) {
        tip.add(t, error);
    }
    of_tip(&tip)
}
