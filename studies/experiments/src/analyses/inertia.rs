//! The paper's robustness table `tab:rmse_uncertainties`, for `table` and the report: tip RMSE
//! under inertia errors on both trajectories, here for three controllers (those of `compare`).

use anyhow::Result;
use cosim::run::observer::Observers;
use cosim::{Experiment, System, Verdict};

use crate::measures::run::{TipError, run as run_once};
use crate::runs::grid::{Case, Cell, Grid, Plan, TRAJECTORIES};
use crate::setup::start_values::laws_of_modes;
use crate::worlds::SCALES;

/// Controllers, in the order of the columns.
pub const MODES: [&str; 3] = ["adaptive", "modular", "pd"];
/// The paper's RMSE of its adaptive controller on each of [`TRAJECTORIES`] for [`SCALES`], m.
const PAPER: [[f64; 5]; 2] = [
    [0.0024, 0.0019, 0.0015, 0.0029, 0.0036],
    [0.0042, 0.0035, 0.0029, 0.0050, 0.0060],
];

/// The paper's RMSE of the adaptive controller, m, where it gives one.
pub fn paper(trajectory: &str, scale: f64) -> Option<f64> {
    let column = TRAJECTORIES.iter().position(|name| *name == trajectory)?;
    let row = SCALES.iter().position(|s| (s - scale).abs() < 1e-9)?;
    Some(PAPER[column][row])
}

/// Factor on all inertias of the manipulator in a cell, which must be of this analysis.
pub fn scale_of<T>(cell: &Cell<T>) -> f64 {
    cell.case.parse().expect("cases are named by their scales")
}

/// Number of cells.
pub const CELLS: usize = TRAJECTORIES.len() * SCALES.len() * MODES.len();

/// Runs all cells under `base` and takes the tip error; see [`measured`].
pub(crate) fn run(
    system: &System,
    base: &Experiment,
    done: impl Fn() + Sync,
) -> Result<Vec<Cell<TipError>>> {
    let measure = |plan: &Plan| {
        let none = &mut Observers(Vec::new());
        let outcome = run_once(system, &plan.experiment, &|_, _| (), none)?;
        Ok((outcome.tip, outcome.verdict()))
    };
    measured(system, base, measure, done)
}

/// Runs all cells under `base`, the controllers of a scale one after the other, with what `measure`
/// makes of a run; `done` is called after each. Fails before the first run if `base` sets what is
/// varied here.
pub fn measured<T: Send>(
    system: &System,
    base: &Experiment,
    measure: impl Fn(&Plan) -> Result<(T, Verdict)> + Sync,
    done: impl Fn() + Sync,
) -> Result<Vec<Cell<T>>> {
    let case = |scale: f64| {
        let setting = system.setting("inertia_scale", scale)?;
        Ok(Case::new(scale.to_string(), vec![setting]))
    };
    let cases = SCALES.into_iter().map(case).collect::<Result<Vec<_>>>()?;
    Grid::new(system, base, &laws_of_modes(&MODES), &cases).run(measure, done)
}
