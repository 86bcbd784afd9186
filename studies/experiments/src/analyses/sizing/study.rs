//! Whether motors and actuators fit what they do: root mean squares and peaks beside ratings,
//! torque over speed under the continuous and the peak envelope, temperatures over an hour of
//! repetitions, and how power, force, energy and efficiency follow the payload at the tip.

use anyhow::{Result, ensure};
use cosim::{Experiment, System, Verdict};
use machine_file::{Machine, Ratings};
use serde::Serialize;

use super::axis::{Axis, axis};
use super::payload::{Sensitivity, sensitivity};
use super::recorded::{columns, parameters_of, ports};
use crate::measures::energy;
use crate::measures::run::RecordedRun;
use crate::setup::machine_choice::MachineFile;

/// All axes of one case.
#[derive(Clone, Debug, Serialize)]
pub struct Sizing {
    /// The axes.
    pub axes: Vec<Axis>,
    /// By payload; empty where it was not varied.
    pub payload: Vec<Sensitivity>,
    /// What spoils the run itself.
    #[serde(skip)]
    pub run: Verdict,
}

/// Run the experiment, and twice more with the payload `payload_step`, kg, less and more where that
/// is not 0.
pub fn run(system: &System, experiment: &Experiment, payload_step: f64) -> Result<Sizing> {
    let recorded = RecordedRun::record(system, experiment, &ports(system)?)?;
    let mut sizing = evaluate(system, experiment, &recorded)?;
    if payload_step != 0.0 {
        sizing.payload = sensitivity(system, experiment, &recorded, payload_step)?;
    }
    Ok(sizing)
}

/// A run of the experiment of which [`ports`] were recorded.
///
/// # Errors
/// One was not, or an actuator has no ratings.
pub fn evaluate(
    system: &System,
    experiment: &Experiment,
    recorded: &RecordedRun,
) -> Result<Sizing> {
    let machine = MachineFile::from_manipulator(system, &experiment.settings)?.machine;
    let lowest = lowest_voltage(system, recorded)?;
    let mut axes = Vec::new();
    for k in energy::actuators(system) {
        let columns = columns(system, recorded, k)?;
        let ratings = ratings_of(system, experiment, k, axes.len(), &machine)?;
        axes.push(axis(system, experiment, k, &columns, lowest, &ratings)?);
    }
    let mut spoilt = Verdict::default();
    let findings = recorded.outcome.run.verdict.findings().iter();
    findings
        .filter(|f| f.is_bad)
        .for_each(|f| spoilt.object(f.text.clone()));
    Ok(Sizing {
        axes,
        payload: Vec::new(),
        run: spoilt,
    })
}

impl Sizing {
    /// What is beyond a rating, and what spoils the run itself.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = self.run.clone();
        self.axes.iter().for_each(|axis| axis.judge(&mut verdict));
        verdict
    }
}

/// Least voltage of the link over the motion, V, where a component tells it.
fn lowest_voltage(system: &System, recorded: &RecordedRun) -> Result<Option<f64>> {
    let Ok(port) = system.port("v_dc_mean") else {
        return Ok(None);
    };
    Ok(recorded.motion(port)?.iter().copied().reduce(f64::min))
}

/// Ratings of actuator `k`: of the axis that its parameter `axis` names; without one, of the place
/// that it has among the actuators.
fn ratings_of(
    system: &System,
    experiment: &Experiment,
    k: usize,
    place: usize,
    machine: &Machine,
) -> Result<Ratings> {
    let index = match parameters_of(system, experiment, k, ["axis"])? {
        Some([axis]) => axis as usize - 1,
        None => place,
    };
    let ratings = machine.ratings.in_order();
    ensure!(
        index < ratings.len(),
        "the machine has ratings for {} actuators, but there are more",
        ratings.len()
    );
    Ok(*ratings[index])
}
