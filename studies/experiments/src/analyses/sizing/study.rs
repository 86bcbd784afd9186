//! Sizing of all axes in one run, for the subcommand `sizing` and the report: RMS and peaks against
//! ratings, torque over speed within the continuous and the peak envelope, temperatures over an
//! hour of repetitions, and the sensitivity of power, force, energy and efficiency to the payload.

use anyhow::{Context, Result};
use cosim::{Experiment, System, Verdict};
use serde::Serialize;

use super::axis::Axis;
use super::payload::{Sensitivity, sensitivity};
use super::recorded::{columns, ports, start_values};
use crate::analyses::trials::strays;
use crate::measures::energy;
use crate::measures::run::RecordedRun;
use crate::setup::machine_choice::MachineFile;
use crate::setup::run_setup::RunSetup;

/// All axes of one case.
#[derive(Clone, Debug, Serialize)]
pub struct Sizing {
    /// The axes.
    pub axes: Vec<Axis>,
    /// Sensitivity to the payload; empty where it was not varied.
    pub payload: Vec<Sensitivity>,
    /// The bad findings of the run, a tip error too large for the reach, and the ratings that are
    /// exceeded.
    #[serde(skip)]
    pub verdict: Verdict,
}

/// Runs the experiment, and unless `payload_step`, kg, is 0 twice more with that payload less and
/// more.
pub fn run(system: &System, experiment: &Experiment, payload_step: f64) -> Result<Sizing> {
    let recorded = RecordedRun::record(system, experiment, &ports(system)?)?;
    let mut sizing = evaluate(system, experiment, &recorded)?;
    if payload_step != 0.0 {
        sizing.payload = sensitivity(system, experiment, &recorded, payload_step)?;
    }
    Ok(sizing)
}

/// [`run`] for the trajectories of a setup, or the one that it sets; `tell` gets each when it is done.
/// Second, the verdict on all.
pub fn cases(
    setup: RunSetup,
    payload_step: f64,
    tell: impl Fn(&str, &Sizing) -> Result<()>,
) -> Result<(Vec<(String, Sizing)>, Verdict)> {
    let (system, base, mut verdict) = setup.into_parts();
    let mut done = Vec::new();
    for (case, experiment) in energy::trajectory_cases(&system, &base)? {
        let found = run(&system, &experiment, payload_step)?;
        tell(&case, &found)?;
        verdict.extend(found.verdict.clone().prefixed(&case));
        done.push((case, found));
    }
    Ok((done, verdict))
}

/// Evaluates a run of the experiment in which [`ports`] were recorded. Fails if one was not, or an
/// actuator has no ratings.
pub fn evaluate(
    system: &System,
    experiment: &Experiment,
    recorded: &RecordedRun,
) -> Result<Sizing> {
    let machine = MachineFile::from_manipulator(system, &experiment.settings)?.machine;
    // Least voltage of the link over the motion, V.
    let lowest = match system.port("v_dc_mean") {
        Ok(port) => recorded.motion(port)?.iter().copied().reduce(f64::min),
        Err(_) => None,
    };
    let mut axes = Vec::new();
    for k in energy::actuators(system) {
        let columns = columns(system, recorded, k)?;
        // Ratings of the axis that its parameter names; without one, by its position.
        let index = match start_values(system, experiment, k, ["axis"])? {
            Some([axis]) => axis as usize - 1,
            None => axes.len(),
        };
        let ratings = machine.ratings.in_order();
        let ratings = ratings.get(index).with_context(|| {
            let count = ratings.len();
            format!("the machine has ratings for {count} actuators, but the system has more")
        })?;
        axes.push(Axis::new(system, experiment, k, &columns, lowest, ratings)?);
    }
    let mut verdict = Verdict::default();
    for finding in recorded.outcome.verdict().findings() {
        if finding.is_bad {
            verdict.object(finding.text.clone());
        }
    }
    // Loads of a machine that swings on its path are none of the path's.
    let strays = strays(&machine, recorded.outcome.tip.motion.rms());
    strays.into_iter().for_each(|text| verdict.object(text));
    axes.iter().for_each(|axis| axis.judge(&mut verdict));
    Ok(Sizing {
        axes,
        payload: Vec::new(),
        verdict,
    })
}
