//! The surrogate in the loop: the machine on rigs with sensors, with load cells and rod encoders and
//! without, whose controller reckons with physics, refitted physics, hybrid or network; how it
//! tracks, what current it requires beside what the motors take, and what each model predicts of
//! current and efficiency along the way.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result};
use cosim::{Experiment, System, Verdict};
use emla::Surrogate;
use machine_file::{Emla, Machine, PerAxis};
use serde::Serialize;
use surrogate::judgement::resampling::bootstrap;
use surrogate::measurement::campaign::{rms, training_campaign};
use surrogate::measurement::coupled_run::CoupledRun;
use surrogate::prediction::identification::Identification;
use surrogate::prediction::model::{Errors, MODELS, Model, errors};
use tempfile::TempDir;

use crate::measures::tracking::Tracking;
use crate::runs::grid::{self, Case, Grid, Plan, TRAJECTORIES};
use crate::setup::start_values::{Law, SHIPPED};
use crate::worlds::{Bounds, Cases};

/// What is read, and whether the observer of the disturbance runs on it: name, and what is set
/// besides the system's parameter set. Without load cells the force is that of the current without
/// losses; an observer that takes it for measured finds what friction the model compensates for
/// unexplained, and takes it away again. Without encoders at the rods their speeds come from the
/// encoders of the joints, 17 bits a turn at an arm of some 0.35 m: as of 16 bits a metre.
const SENSORS: [(&str, &[(&str, &str)]); 3] = [
    ("with", &[]),
    ("without", &WITHOUT),
    (
        "without, no observer",
        &[WITHOUT[0], WITHOUT[1], ("controller.omega_d", "0")],
    ),
];
/// See [`SENSORS`].
const WITHOUT: [(&str, &str); 2] = [
    ("sensors.force", "absent"),
    ("sensors.rod_encoder.bits", "16"),
];
/// What the controller reckons with: name, share of the network, and whether its machine file has
/// the refitted actuators.
const CONTROLLERS: [(&str, f64, bool); 4] = [
    ("physics", 0.0, false),
    ("refitted", 0.0, true),
    ("hybrid", 0.9, false),
    ("network", 1.0, false),
];
/// Seeds of the machines of this analysis alone.
const FIRST_SEED: u64 = 7001;
/// Machines where no number is asked for.
pub const MACHINES: u64 = 3;

/// Runs that [`run`] makes on `machines`.
pub fn runs(machines: usize) -> usize {
    SENSORS.len() * CONTROLLERS.len() * TRAJECTORIES.len() * machines
}

/// The first `count` machines of this analysis; their files exist as long as these.
pub fn machines(system: &System, count: u64) -> Result<Cases> {
    Cases::of_machines(system, FIRST_SEED..FIRST_SEED + count, &Bounds::REAL)
}

/// The network that was trained on the rig, and the machine with the actuators that were refitted
/// to the same data, in files that FMUs can read as long as this lives.
pub struct RigNetwork {
    _folder: TempDir,
    /// The network's file.
    pub path: PathBuf,
    /// The machine's.
    refitted: PathBuf,
    /// The network.
    pub network: Surrogate,
}

impl RigNetwork {
    /// Write them; the actuators are refitted to a campaign that is run for it.
    pub fn new() -> Result<Self> {
        let folder = TempDir::new().context("no folder for the rig's network")?;
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
    /// Load cells and rod encoders, of `SENSORS`.
    pub sensors: String,
    /// Model that the controller reckons with.
    pub model: String,
    /// The machine.
    pub machine: String,
    /// No limit of the machine was exceeded for long, and the supervisor did not stop it.
    pub kept: bool,
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
    /// Windows of 20 ms in which the efficiency is defined: time, s, true efficiency, that of
    /// physics, hybrid and network.
    pub efficiency: Vec<[f64; 5]>,
}

/// The lift axis among the actuators.
const LIFT: usize = 1;

/// All runs on `machines` in the `system` of the real world, in parallel, and what spoils them.
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
    let grid = Grid::new(system, base, &laws, machines).varying_bound();
    let measure = |plan: &Plan| {
        let name = || format!("{}, {}, {}", plan.trajectory, plan.law, plan.case);
        measure(system, plan, network).with_context(name)
    };
    let cells = grid.run(measure, done)?;
    let verdict = grid::verdict(&cells);
    let runs = cells.into_iter().map(|cell| cell.result);
    Ok((runs.collect::<Result<_>>()?, verdict))
}

/// Runs with the same sensors and controller.
#[derive(Clone, Debug, Serialize)]
pub struct SurrogateRow {
    /// Load cells and rod encoders, of `SENSORS`.
    pub sensors: &'static str,
    /// Model that the controller reckons with.
    pub model: &'static str,
    /// How many runs were stopped or spoilt, of how many.
    pub failed: [usize; 2],
    /// Known error of the tip, root mean square over the motion, m: geometric mean over the
    /// machines and paths that all controllers with these sensors kept, with its 95 % interval
    /// (bootstrap over machines, the paths of one drawn together).
    pub tip: [f64; 3],
    /// The largest of them, m.
    pub worst: f64,
    /// Required less true current, A, likewise.
    pub current: [f64; 3],
    /// Tip's error over that with the physics on the same machine and path, likewise.
    pub ratio: [f64; 3],
}

/// The runs in rows.
pub fn rows(runs: &[SurrogateRun]) -> Vec<SurrogateRow> {
    let of = |sensors: &str, model: &str| -> Vec<&SurrogateRun> {
        let wanted = runs
            .iter()
            .filter(|r| r.sensors == sensors && r.model == model);
        wanted.collect()
    };
    let row = |sensors: &'static str, model: &'static str| {
        // Runs come in the same order of paths and machines for each controller.
        let (own, physics) = (of(sensors, model), of(sensors, CONTROLLERS[0].0));
        let all = CONTROLLERS.map(|(model, ..)| of(sensors, model));
        let mut machines: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (k, run) in own.iter().enumerate() {
            if all.iter().all(|runs| runs[k].kept) {
                machines.entry(&run.machine).or_default().push(k);
            }
        }
        let machines: Vec<Vec<usize>> = machines.into_values().collect();
        let mean = |value: &dyn Fn(usize) -> f64| {
            let of = |drawn: &[usize]| {
                let logs = drawn.iter().flat_map(|&m| &machines[m]);
                let (sum, n) = logs.fold((0.0, 0.0), |(sum, n), &k| (sum + value(k).ln(), n + 1.0));
                f64::exp(sum / n)
            };
            match machines.len() {
                0 => [f64::NAN; 3],
                count => bootstrap(count, of),
            }
        };
        let kept = machines.iter().flatten();
        SurrogateRow {
            sensors,
            model,
            failed: [own.iter().filter(|run| !run.kept).count(), own.len()],
            tip: mean(&|k| own[k].tip),
            worst: kept.map(|&k| own[k].tip).fold(0.0, f64::max),
            current: mean(&|k| own[k].current),
            ratio: mean(&|k| own[k].tip / physics[k].tip),
        }
    };
    let all = SENSORS.iter().flat_map(|(sensors, _)| {
        CONTROLLERS
            .iter()
            .map(move |(model, ..)| (*sensors, *model))
    });
    all.map(|(sensors, model)| row(sensors, model)).collect()
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
    let efficiency = run.axis_windows(LIFT, &p, start).into_iter();
    let efficiency = efficiency.filter_map(|(t, truth)| {
        let of = |k: usize| models[k].demand(&truth.motion).efficiency;
        Some([t, truth.efficiency()?, of(0), of(1), of(2)])
    });
    let lift = LiftCourse {
        current: run.currents(LIFT, start).map(<[f64]>::to_vec),
        efficiency: efficiency.collect(),
    };
    let (sensors, model) = plan.law.split_once("; ").context("a law of this study")?;
    let measured = SurrogateRun {
        trajectory: plan.trajectory,
        sensors: sensors.into(),
        model: model.into(),
        machine: plan.case.into(),
        kept: !recorded.outcome.limits.is_bad(),
        tip: tracking.known.rmse,
        current: rms(run.current_errors(start)),
        predicted,
        lift,
    };
    Ok((measured, recorded.outcome.verdict()))
}
