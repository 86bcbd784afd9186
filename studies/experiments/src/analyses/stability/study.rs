//! The runs along which the stability proof is evaluated, for the subcommand `stability` and the
//! report: both trajectories with the paper's and the shipped law, at two communication steps.

use anyhow::{Context as _, Result};
use cosim::{Experiment, Setting, System, Verdict};

use super::run::{Run, measure};
use crate::runs::grid::{self, Case, Grid, Plan, TRAJECTORIES};
use crate::setup::start_values::Law;

/// Laws, and the gains that are set to 0: without the extensions of the voltage law, and with them.
const LAWS: [(&str, &[&str]); 2] = [("paper", &["omega_i", "omega_d"]), ("shipped", &[])];
/// Steps over the communication step of the experiment.
const STEPS: [f64; 2] = [1.0, 0.25];
/// Number of runs that [`run`] makes.
pub const RUNS: u64 = (TRAJECTORIES.len() * LAWS.len() * STEPS.len()) as u64;

/// Sets the plant's inertia over nominal, also for the accompanying functions.
pub(super) fn inertia_settings(system: &System, scale: f64) -> Result<Vec<Setting>> {
    let variables = ["lyapunov.inertia_scale", "inertia_scale"];
    let settings = variables.map(|variable| system.setting(variable, scale));
    settings.into_iter().collect()
}

/// Runs both trajectories with both laws, at the step of `base` and at a quarter of it; `scale` is
/// the plant's inertia over nominal. Returns the runs and the verdict on them. Fails if `base` sets
/// what is varied here.
pub fn run(
    system: &System,
    base: &Experiment,
    scale: f64,
    done: impl Fn() + Sync,
) -> Result<(Vec<Result<Run>>, Verdict)> {
    let law = |(name, off): (&str, &[&str])| Law {
        name: name.into(),
        values: off.iter().map(|v| ((*v).into(), "0".into())).collect(),
    };
    let settings = inertia_settings(system, scale)?;
    let case = |part: f64| Case {
        step: part,
        ..Case::new(
            format!("step {} s", part * base.stepping.step),
            settings.clone(),
        )
    };
    let (laws, cases) = (LAWS.map(law), STEPS.map(case));
    let measure = |plan: &Plan| {
        let name = || format!("{}, {} law, {}", plan.trajectory, plan.law, plan.case);
        measure(system, plan).with_context(name)
    };
    let mut cells = Grid::new(system, base, &laws, &cases).run(measure, done)?;
    // Trajectory by trajectory, law by law, step by step.
    cells.sort_by(|a, b| (a.trajectory, &a.law).cmp(&(b.trajectory, &b.law)));
    let verdict = grid::verdict(&cells);
    Ok((cells.into_iter().map(|cell| cell.result).collect(), verdict))
}

/// Makes the verdict bad where a gain condition fails, apart from the first as printed: that one, with
/// a weight of 1 A/N, is only reported.
pub(crate) fn judge(runs: &[Run], verdict: &mut Verdict) {
    let Some(run) = runs.first() else { return };
    let [_printed, required @ ..] = run.gains.conditions();
    for c in required.iter().filter(|c| !c.holds()) {
        verdict.object(format!(
            "gain condition {}: {:.3e} {unit}, but it must be at least {:.3e} {unit}",
            c.statement,
            c.value,
            c.bound,
            unit = c.unit
        ));
    }
}
