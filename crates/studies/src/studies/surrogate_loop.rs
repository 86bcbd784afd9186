//! The surrogate in the loop: the machine on rigs with sensors, whose controller reckons with physics, hybrid or network, under the shipped
//! law and the paper's; how it tracks, what current it requires beside what the motors take, and what each model predicts of current and
//! efficiency along the way.

use std::path::PathBuf;

use anyhow::{Context, Result};
use cosim::run::Experiment;
use cosim::system::System;
use cosim::verdict::Verdict;
use emla::Surrogate;
use machine::Machine;
use rig_data::campaign::rms;
use rig_data::coupled_run::CoupledRun;
use rig_data::prediction::{Errors, MODELS, Model, Motion, errors};
use serde::Serialize;
use tempfile::TempDir;

use crate::grid::{self, Case, Grid, Plan, TRAJECTORIES};
use crate::laws::Law;
use crate::measures::tracking::Tracking;

/// Laws: name, and what is set for them besides the system's parameter set. The paper's has neither observer nor integral.
const LAWS: [(&str, &[(&str, f64)]); 2] = [
    ("shipped", &[]),
    (
        "paper's",
        &[("controller.omega_i", 0.0), ("controller.omega_d", 0.0)],
    ),
];
/// Runs that [`run`] makes.
pub const RUNS: usize = LAWS.len() * MODELS.len() * TRAJECTORIES.len();

/// The network that was trained on the rig, in a file that FMUs can read as long as this lives.
pub struct RigNetwork {
    _folder: TempDir,
    /// The file.
    pub path: PathBuf,
    /// The network.
    pub network: Surrogate,
}

impl RigNetwork {
    /// Write it.
    pub fn new() -> Result<Self> {
        let folder = TempDir::new().context("no folder for the rig's network")?;
        let path = folder.path().join("surrogate_rig.json");
        std::fs::write(&path, rig_data::RIG_NETWORK).with_context(|| path.display().to_string())?;
        let network = Surrogate::from_json(rig_data::RIG_NETWORK).context("the rig's network")?;
        Ok(Self {
            _folder: folder,
            path,
            network,
        })
    }

    /// Physics, hybrid and network.
    pub fn models(&self) -> [Model; 3] {
        let p = Machine::reference().emla.lift;
        MODELS.map(|(_, alpha)| Model::new(p, self.network.clone(), alpha))
    }
}

/// One run.
#[derive(Clone, Debug, Serialize)]
pub struct SurrogateRun {
    /// Trajectory.
    pub trajectory: &'static str,
    /// `shipped` or `paper's`.
    pub law: String,
    /// Model that the controller reckons with.
    pub model: String,
    /// Root mean square of the tip's known error over the motion, m.
    pub tip: f64,
    /// Of the required less the true current of all axes, A.
    pub current: f64,
    /// What physics, hybrid and network predict, in this order.
    pub predicted: [Errors; 3],
    /// Courses of the lift axis.
    #[serde(skip)]
    pub lift: LiftCourse,
}

/// Courses of the lift axis over the motion.
#[derive(Clone, Debug, Default)]
pub struct LiftCourse {
    /// Times, s, required and true current, A.
    pub current: [Vec<f64>; 3],
    /// Windows of 20 ms in which the efficiency is defined: time, s, true efficiency, that of physics, hybrid and network.
    pub efficiency: Vec<[f64; 5]>,
}

/// The lift axis among the actuators.
const LIFT: usize = 1;

/// All runs on the `system` of the real world, in parallel, and what spoils them.
///
/// # Errors
/// A run fails, or the system has no rigs.
pub fn run(
    system: &System,
    base: &Experiment,
    network: &RigNetwork,
    done: impl Fn() + Sync,
) -> Result<(Vec<SurrogateRun>, Verdict)> {
    let law = |(name, values): (&str, &[(&str, f64)])| Law {
        name: name.into(),
        values: values
            .iter()
            .map(|(variable, value)| ((*variable).into(), value.to_string()))
            .collect(),
    };
    let case = |(model, alpha): (&str, f64)| {
        let settings = vec![
            system.setting("controller.alpha", alpha)?,
            system.setting("controller.surrogate_file", network.path.display())?,
        ];
        Ok(Case::new(model, settings))
    };
    let cases = MODELS.into_iter().map(case).collect::<Result<Vec<_>>>()?;
    let laws = LAWS.map(law);
    let grid = Grid::new(system, base, &laws, &cases).varying_bound();
    let measure = |plan: &Plan| {
        let name = || format!("{}, {} law, {}", plan.trajectory, plan.law, plan.case);
        measure(system, plan, network).with_context(name)
    };
    let mut cells = grid.run(measure, done)?;
    let place = |law: &str| LAWS.iter().position(|(name, _)| *name == law);
    cells.sort_by_key(|cell| (cell.trajectory, place(&cell.law)));
    let verdict = grid::verdict(&cells);
    let runs = cells.into_iter().map(|cell| cell.result);
    Ok((runs.collect::<Result<_>>()?, verdict))
}

fn measure(system: &System, plan: &Plan, network: &RigNetwork) -> Result<(SurrogateRun, Verdict)> {
    let ports: Result<Vec<_>> = CoupledRun::signals()
        .iter()
        .map(|name| system.port(name))
        .collect();
    let (tracking, recorded) = Tracking::recorded(system, &plan.experiment, &ports?)?;
    let recording = &recorded.recording;
    let column = |name: &str| {
        let column = recording.column(system.port(name)?);
        column.map(<[f64]>::to_vec)
    };
    let run = CoupledRun::new(recording.times.clone(), column)?;
    let start = recorded.outcome.tip.motion_start;
    let (p, models) = (Machine::reference().emla.lift, network.models());
    let windows = run.windows(&p, start);
    let predicted = [0, 1, 2].map(|k: usize| errors(&models[k], &windows));
    let efficiency = run.windows_of(LIFT, &p, start).into_iter();
    let efficiency = efficiency.filter_map(|(t, truth)| {
        let of = |k: usize| models[k].demand(&Motion::from(&truth)).efficiency;
        Some([t, truth.efficiency()?, of(0), of(1), of(2)])
    });
    let lift = LiftCourse {
        current: run.currents(LIFT, start).map(<[f64]>::to_vec),
        efficiency: efficiency.collect(),
    };
    let measured = SurrogateRun {
        trajectory: plan.trajectory,
        law: plan.law.into(),
        model: plan.case.into(),
        tip: tracking.known.rmse,
        current: rms(run.current_errors(start)),
        predicted,
        lift,
    };
    Ok((measured, recorded.outcome.verdict()))
}
