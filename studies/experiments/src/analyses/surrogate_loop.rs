//! The surrogate in the loop, for `table --study surrogate` and the report: the machine on rigs,
//! with and without load cells and rod encoders, whose controller computes with physics, refitted
//! physics, hybrid or network. Measured are the tracking, the current that the controller requires
//! against the motors' true one, and each model's predictions of current and efficiency.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result};
use cosim::{Experiment, System, Verdict};
use emla::Surrogate;
use machine_file::{Emla, Machine, PerAxis};
use output_file::TemporaryFolder;
use serde::Serialize;
use surrogate::judgement::resampling::bootstrap;
use surrogate::measurement::campaign::{rms, training_campaign};
use surrogate::measurement::coupled_run::CoupledRun;
use surrogate::prediction::identification::Identification;
use surrogate::prediction::model::{Errors, MODELS, Model, errors};

use crate::measures::tracking::Tracking;
use crate::runs::grid::{self, Case, Grid, Plan, TRAJECTORIES};
use crate::setup::start_values::{Law, SHIPPED};
use crate::worlds::{Bounds, Cases};

/// Load cells and rod encoders, and whether the disturbance observer runs: name, and what is set
/// besides the system's parameter set. Without load cells the force is computed from the current
/// without losses; an observer that takes it for measured regards the friction that the model
/// compensates for as unexplained, and takes it away again. Without rod encoders the rod speeds come
/// from the joint encoders, 17 bits a turn at an arm of some 0.35 m: as of 16 bits a metre.
const SENSORS: [(&str, &[(&str, &str)]); 3] = [
    ("with", &[]),
    ("without", WITHOUT.split_at(2).0),
    ("without, no observer", &WITHOUT),
];
/// See [`SENSORS`].
const WITHOUT: [(&str, &str); 3] = [
    ("sensors.force", "absent"),
    ("sensors.rod_encoder.bits", "16"),
    ("controller.omega_d", "0"),
];
/// Models that the controller computes with: name, share of the network, and whether its machine
/// file has the refitted actuators.
const CONTROLLERS: [(&str, f64, bool); 4] = [
    ("physics", 0.0, false),
    ("refitted", 0.0, true),
    ("hybrid", 0.9, false),
    ("network", 1.0, false),
];
/// First seed of the machines, which no other analysis draws.
const FIRST_SEED: u64 = 7001;
/// Machines where no number is asked for.
pub(crate) const MACHINES: u64 = 3;

/// Number of runs that [`run`] makes on `machines`.
pub(crate) fn runs(machines: usize) -> usize {
    SENSORS.len() * CONTROLLERS.len() * TRAJECTORIES.len() * machines
}

/// The first `count` machines of this analysis; their files exist as long as the result lives.
pub(crate) fn machines(system: &System, count: u64) -> Result<Cases> {
    Cases::draw_machines(system, FIRST_SEED..FIRST_SEED + count, &Bounds::REAL)
}

/// The network that was trained on the rig, and the machine with actuators refitted to the same
/// data. FMUs can read their files as long as this lives.
pub struct RigNetwork {
    _folder: TemporaryFolder,
    /// The network's file.
    pub(crate) path: PathBuf,
    /// The machine's file.
    refitted: PathBuf,
    /// The network.
    pub network: Surrogate,
}

impl RigNetwork {
    /// Writes the files; runs the campaign to which the actuators are refitted.
    pub fn new() -> Result<Self> {
        let folder = TemporaryFolder::new().context("no folder for the rig's network")?;
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).with_context(|| path.display().to_string())?;
            anyhow::Ok(path)
        };
        let network = Surrogate::from_json(surrogate::RIG_NETWORK).context("the rig's network")?;
        let mut machine = Machine::reference();
        let campaign = training_campaign(&machine.emla.lift, 1)?;
        let found = Identification::new(&machine.emla.lift, &campaign).refitted;
        machine.emla = PerAxis::all(Emla {
            tau_C: found.tau_C,
            C_m: found.C_m,
            eta_gear: found.eta_gear,
            lambda_m: found.lambda_m,
            temperature: found.temperature,
            ..machine.emla.lift
        });
        let machine = serde_json::to_string_pretty(&machine)?;
        Ok(Self {
            path: write("surrogate_rig.json", surrogate::RIG_NETWORK)?,
            refitted: write("refitted.json", &machine)?,
            network,
            _folder: folder,
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
    /// Load cells and rod encoders: a name of `SENSORS`.
    pub sensors: String,
    /// Model that the controller computes with.
    pub model: String,
    /// The machine.
    pub machine: String,
    /// Whether the supervisor did not stop the machine, and no limit was exceeded for long.
    pub kept: bool,
    /// Root mean square of the tip's known error over the motion, m.
    pub tip: f64,
    /// Root mean square of required less true current of all axes, A.
    pub current: f64,
    /// Errors of what physics, hybrid and network predict, in this order.
    pub predicted: [Errors; 3],
    /// Of the lift axis over the motion: times, s, required and true current, A.
    #[serde(skip)]
    pub lift_current: [Vec<f64>; 3],
    /// Of the lift axis in windows of 20 ms in which the efficiency is defined: time, s, true
    /// efficiency, that of physics, hybrid and network.
    #[serde(skip)]
    pub lift_efficiency: Vec<[f64; 5]>,
}

/// The lift axis among the actuators.
const LIFT: usize = 1;

/// All runs on `machines` in the `system` of the real world, in parallel, and the verdict on them.
pub fn run(
    system: &System,
    base: &Experiment,
    network: &RigNetwork,
    machines: &[Case],
    done: impl Fn() + Sync,
) -> Result<(Vec<SurrogateRun>, Verdict)> {
    let mut laws = Vec::new();
    for (sensors, readings) in SENSORS {
        for (model, alpha, refitted) in CONTROLLERS {
            let mut law = Law::new(format!("{sensors}; {model}"), SHIPPED);
            for (variable, value) in readings {
                law = law.with(variable, value);
            }
            law = law
                .with("controller.alpha", alpha)
                .with("controller.surrogate_file", network.path.display());
            if refitted {
                law = law.with("controller.machine_file", network.refitted.display());
            }
            laws.push(law);
        }
    }
    let grid = Grid::new(system, base, &laws, machines).replacing_bound();
    let measure = |plan: &Plan| {
        let name = || format!("{}, {}, {}", plan.trajectory, plan.law, plan.case);
        measure(system, plan, network).with_context(name)
    };
    let cells = grid.run(measure, done)?;
    let verdict = grid::verdict(&cells);
    let runs = cells.into_iter().map(|cell| cell.result);
    Ok((runs.collect::<Result<_>>()?, verdict))
}

/// Runs with the same sensors and controller. Means are geometric, over the machines and paths that
/// all controllers with these sensors kept, with their 95 % interval (bootstrap over machines, the
/// paths of one drawn together).
#[derive(Clone, Debug, Serialize)]
pub struct SurrogateRow {
    /// Load cells and rod encoders: a name of `SENSORS`.
    pub sensors: &'static str,
    /// Model that the controller computes with.
    pub model: &'static str,
    /// Number of runs that were not kept, and of all.
    pub failed: [usize; 2],
    /// Mean of the tip's known error, root mean square over the motion, m.
    pub tip: [f64; 3],
    /// The largest of these errors, m.
    pub worst: f64,
    /// Mean of required less true current, root mean square over the motion, A.
    pub current: [f64; 3],
    /// Mean of the tip's error over that with the physics on the same machine and path.
    pub ratio: [f64; 3],
}

/// The runs in rows, sensors by sensors, controller by controller.
pub(crate) fn rows(runs: &[SurrogateRun]) -> Vec<SurrogateRow> {
    // Runs come in the same order of paths and machines for each controller.
    let select = |sensors: &str, model: &str| -> Vec<&SurrogateRun> {
        let is_wanted = |r: &&SurrogateRun| r.sensors == sensors && r.model == model;
        runs.iter().filter(is_wanted).collect()
    };
    let mut rows = Vec::new();
    for (sensors, _) in SENSORS {
        let all = CONTROLLERS.map(|(model, ..)| select(sensors, model));
        let mut machines: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (k, run) in all[0].iter().enumerate() {
            if all.iter().all(|runs| runs[k].kept) {
                machines.entry(&run.machine).or_default().push(k);
            }
        }
        let machines: Vec<Vec<usize>> = machines.into_values().collect();
        let mean = |value: &dyn Fn(usize) -> f64| {
            let over = |drawn: &[usize]| {
                let logs = drawn.iter().flat_map(|&m| &machines[m]);
                let (sum, n) = logs.fold((0.0, 0.0), |(sum, n), &k| (sum + value(k).ln(), n + 1.0));
                f64::exp(sum / n)
            };
            match machines.len() {
                0 => [f64::NAN; 3],
                count => bootstrap(count, over),
            }
        };
        let physics = &all[0];
        for ((model, ..), own) in CONTROLLERS.into_iter().zip(&all) {
            rows.push(SurrogateRow {
                sensors,
                model,
                failed: [own.iter().filter(|run| !run.kept).count(), own.len()],
                tip: mean(&|k| own[k].tip),
                worst: (machines.iter().flatten())
                    .map(|&k| own[k].tip)
                    .fold(0.0, f64::max),
                current: mean(&|k| own[k].current),
                ratio: mean(&|k| own[k].tip / physics[k].tip),
            });
        }
    }
    rows
}

fn measure(system: &System, plan: &Plan, network: &RigNetwork) -> Result<(SurrogateRun, Verdict)> {
    let names = CoupledRun::signals();
    let ports: Result<Vec<_>> = names.iter().map(|name| system.port(name)).collect();
    let (tracking, recorded) = Tracking::record(system, &plan.experiment, &ports?)?;
    let recording = &recorded.recording;
    let column = |name: &str| {
        let column = recording.column(system.port(name)?);
        column.map(<[f64]>::to_vec)
    };
    let run = CoupledRun::new(recording.times.clone(), column)?;
    let start = recorded.outcome.tip.motion_start;
    let (p, models) = (Machine::reference().emla.lift, network.models());
    let windows = run.windows(&p, start);
    let efficiency = run.axis_windows(LIFT, &p, start).into_iter();
    let efficiency = efficiency.filter_map(|(t, truth)| {
        let [physics, hybrid, net] = models
            .each_ref()
            .map(|m| m.demand(&truth.motion).efficiency);
        Some([t, truth.efficiency()?, physics, hybrid, net])
    });
    let (sensors, model) = plan.law.split_once("; ").context("a law of this study")?;
    let measured = SurrogateRun {
        trajectory: plan.trajectory,
        sensors: sensors.into(),
        model: model.into(),
        machine: plan.case.into(),
        kept: !recorded.outcome.limits.is_bad(),
        tip: tracking.known.rmse,
        current: rms(run.current_errors(start)),
        predicted: models.each_ref().map(|model| errors(model, &windows)),
        lift_current: run.currents(LIFT, start).map(<[f64]>::to_vec),
        lift_efficiency: efficiency.collect(),
    };
    Ok((measured, recorded.outcome.verdict()))
}
