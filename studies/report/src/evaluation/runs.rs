//! The runs of the paper's table, with signals and energies for the page and its figures.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use cosim::exchange::bond::Residual;
use cosim::{Experiment, Port, System, Verdict, matching};
use serde::Serialize;
use serde_json::{Value, json};

use super::request::{Request, UNCERTAIN};
use super::samples::{EVERY, Samples, Tolerance, stride};
use super::scene::Scene;
use experiments::analyses::inertia::MODES;
use experiments::analyses::testbed::{self, MachineRun};
use experiments::measures::energy;
use experiments::measures::run::{RecordedRun, TipError};
use experiments::print::energy::balance_json;
use experiments::runs::grid::{Cell, Plan};
use experiments::setup::start_values::vary;

/// Time between two samples of the tip error, s.
const TIP_EVERY: f64 = 0.004;

/// How far the page's curves may be from a signal. A plot is some 250 points of the screen high, so
/// this part of its range, or on a logarithmic axis of the value, is a fraction of one of them. The
/// distance of two positions is magnified up to a thousand times.
const OF_RANGE: Tolerance = Tolerance::OfRange(5e-4);
const OF_LOGARITHM: Tolerance = Tolerance::Relative(0.01);
const OF_POSITION: Tolerance = Tolerance::Absolute(2e-6);

/// Outputs that the page plots, as far as the system has them.
const PLOTTED: [&str; 28] = [
    "controller.tip_error*",
    "controller.desired.position[*]",
    "controller.f_required[*]",
    "controller.x_dot_required[*]",
    "controller.i_q_required[*]",
    "controller.v_d[*]",
    "controller.v_q[*]",
    "controller.tau_wrist[*]",
    "controller.mass_hat.*",
    "controller.lyapunov.nu_*",
    "controller.lyapunov.vpf[*]",
    "controller.lyapunov.dissipation",
    "hdrm.zeta[*]",
    "hdrm.x[*]",
    "hdrm.x_dot[*]",
    "hdrm.tip.position[*]",
    "hdrm.energy.*",
    "emla_*.F",
    "emla_*.i_d",
    "emla_*.i_q",
    "emla_*.w_m",
    "emla_*.P_in",
    "emla_*.loss.copper",
    "emla_*.loss.core",
    "emla_*.loss.inverter",
    "emla_*.loss.mechanical",
    "emla_*.efficiency",
    "emla_*.efficiency_valid",
];

/// Conditions of one run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Case {
    pub trajectory: &'static str,
    pub mode: &'static str,
    /// Factor on all inertias of the manipulator.
    pub scale: f64,
}

/// A signal, sampled from the start of the run.
#[derive(Serialize)]
pub struct Signal {
    /// Unit in the model description.
    pub unit: String,
    /// Time between samples, s.
    pub every: f64,
    #[serde(skip)]
    pub samples: Samples,
    /// What of the samples the page needs.
    sparse: String,
}

#[derive(Serialize)]
pub struct Run {
    #[serde(flatten)]
    pub case: Case,
    /// Start time, s.
    pub start: f64,
    /// Simulated time, s.
    pub simulated: f64,
    /// Time at which the reference starts to move, s.
    pub motion_start: f64,
    /// Tip error over the motion at every communication point, m.
    pub rmse: f64,
    pub max: f64,
    /// Tip error over the whole run, including the time in which the machine settles, m.
    whole_rmse: f64,
    whole_max: f64,
    pub real_time_factor: f64,
    /// Power residual of each bond.
    bonds: Vec<Value>,
    warnings: Vec<String>,
    pub signals: BTreeMap<String, Signal>,
    /// Largest distance of the drawn tip from the tip position that the FMU gives, m.
    drawing_error: f64,
}

/// What one run of the paper's table contributes to the page.
pub struct TableRun {
    tip: TipError,
    /// Of the runs that the page plots.
    run: Option<Run>,
    /// Of the adaptive controller with nominal inertias.
    energy: Option<Result<Value>>,
    /// Of the same runs, the loads that the testbed replays, if there is a testbed.
    machine_run: Option<Result<MachineRun>>,
}

/// What all runs of the paper's table contribute to the page.
#[derive(Default)]
pub struct TableRuns {
    pub cells: Vec<Cell<TipError>>,
    /// Both trajectories with all controllers, and with wrong inertias the adaptive one.
    pub runs: Vec<Run>,
    pub energies: Vec<Result<Value>>,
    pub machine_runs: Vec<Result<MachineRun>>,
}

impl TableRuns {
    pub fn from_cells(cells: Vec<Cell<TableRun>>) -> Self {
        let mut all = Self::default();
        for cell in cells {
            let tip = cell.map(|table_run| {
                all.runs.extend(table_run.run);
                all.energies.extend(table_run.energy);
                all.machine_runs.extend(table_run.machine_run);
                table_run.tip
            });
            all.cells.push(tip);
        }
        let is_nominal = |run: &Run| run.case.scale == 1.0;
        let order = |run: &Run| (run.case.trajectory, !is_nominal(run));
        all.runs.sort_by_key(order);
        all
    }
}

/// Makes one run of the paper's table.
pub fn measure(request: &Request<'_>, scene: &Scene, plan: &Plan) -> Result<(TableRun, Verdict)> {
    let system = request.system;
    let mode = MODES.into_iter().find(|mode| *mode == plan.law);
    let case = Case {
        trajectory: plan.trajectory,
        mode: mode.context("a controller of the table")?,
        scale: plan.case.parse()?,
    };
    let is_adaptive = case.mode == MODES[0];
    let is_nominal = case.scale == 1.0;
    let is_plotted = is_nominal || is_adaptive && case.scale == UNCERTAIN;
    let has_energy = is_adaptive && is_nominal;
    let is_replayed = has_energy && request.testbed.is_some();
    let mut experiment = plan.experiment.clone();
    let mut signals: Vec<Port> = Vec::new();
    if is_plotted {
        // The controller's accompanying functions need the plant's true inertias; its law does not
        // see them.
        experiment = vary(
            system,
            &experiment,
            &[("lyapunov.inertia_scale", &case.scale)],
        )?;
        let ports = |pattern: &str| matching(system, &[pattern.into()]).unwrap_or_default();
        signals = PLOTTED.into_iter().flat_map(ports).collect();
    }
    let mut ports = signals.clone();
    if has_energy {
        ports.extend(energy::ports(system).unwrap_or_default());
    }
    if is_replayed {
        ports.extend(testbed::ports(system).unwrap_or_default());
    }
    let recorded = RecordedRun::record(system, &experiment, &ports)?;
    let energy = has_energy.then(|| {
        energies(system, case.trajectory, &recorded)
            .with_context(|| format!("energy, {}", case.trajectory))
    });
    let machine_run = is_replayed.then(|| {
        MachineRun::new(system, case.trajectory, experiment.stepping.step, &recorded)
            .with_context(|| format!("{}, run of the machine", case.trajectory))
    });
    let run = is_plotted.then(|| Run::new(system, &experiment, case, &recorded, &signals, scene));
    let table_run = TableRun {
        tip: recorded.outcome.tip,
        run: run.transpose()?,
        energy,
        machine_run,
    };
    Ok((table_run, recorded.outcome.verdict()))
}

/// Energy balances of a run in which [`energy::ports`] were recorded.
fn energies(system: &System, trajectory: &str, recorded: &RecordedRun) -> Result<Value> {
    let balances = energy::evaluate(system, recorded)?.balances;
    let balances: Vec<_> = balances.iter().map(balance_json).collect();
    Ok(json!({"trajectory": trajectory, "balances": balances}))
}

impl Run {
    fn new(
        system: &System,
        experiment: &Experiment,
        case: Case,
        recorded: &RecordedRun,
        plotted: &[Port],
        scene: &Scene,
    ) -> Result<Self> {
        let (recording, outcome) = (&recorded.recording, &recorded.outcome);
        let step = experiment.stepping.step;
        let mut signals = BTreeMap::new();
        for &port in plotted {
            let name = system.name(port);
            let is_tip = name.starts_with("controller.tip_error");
            let stride = stride(if is_tip { TIP_EVERY } else { EVERY }, step);
            let unit = system.variable(port).unit.as_deref();
            let samples = Samples::thinned(recording.column(port)?, stride);
            let tolerance = match &name {
                n if n.contains("position[") => OF_POSITION,
                n if n.contains("error_norm") || n.contains("lyapunov.nu_") => OF_LOGARITHM,
                _ => OF_RANGE,
            };
            let signal = Signal {
                unit: unit.unwrap_or("1").into(),
                every: step * stride as f64,
                sparse: samples.sparse(tolerance),
                samples,
            };
            signals.insert(name, signal);
        }
        let drawing_error = scene.drawing_error(system, recording, stride(EVERY, step))?;
        let findings = outcome.run.verdict.findings().iter();
        Ok(Self {
            case,
            start: experiment.stepping.start,
            simulated: outcome.run.simulated,
            motion_start: outcome.tip.motion_start,
            rmse: outcome.tip.motion.rms(),
            max: outcome.tip.motion.max,
            whole_rmse: outcome.tip.whole.rms(),
            whole_max: outcome.tip.whole.max,
            real_time_factor: outcome.run.real_time_factor(),
            bonds: outcome.run.residuals.iter().map(bond).collect(),
            warnings: findings.map(|finding| finding.text.clone()).collect(),
            signals,
            drawing_error,
        })
    }

    /// The run in one line of text.
    pub fn line(&self) -> String {
        let (case, [rmse, max]) = (self.case, [self.rmse, self.max].map(|e| 1e3 * e));
        format!(
            "{:<11}{:<9} inertia x {:<4} tip RMSE {rmse:8.4} mm, max {max:8.4} mm",
            case.trajectory, case.mode, case.scale
        )
    }

    /// Times, s, and values of a signal, if the system has it.
    pub fn series(&self, name: &str) -> Option<Vec<(f64, f64)>> {
        let signal = self.signals.get(name)?;
        let at = |k: usize| self.start + k as f64 * signal.every;
        let points = signal.samples.values().enumerate().map(|(k, v)| (at(k), v));
        Some(points.collect())
    }
}

fn bond(r: &Residual) -> Value {
    json!({"bond": r.bond, "peak": r.peak, "energy": r.energy, "turnover": r.turnover})
}
