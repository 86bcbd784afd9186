//! Control laws compared in a world: every law on every case of the world and both trajectories; of each the median and the worst case.
//!
//! - `ideal`: the plant is the controller's own model, all inertias scaled by one factor; a check of the code.
//! - `real`: actuators as built, sensors, one step of delay, and errors of the machine drawn by seed (module `real`);
//! - `bending`: a structure that bends, in MuJoCo, with errors drawn by seed (module `bending`).
#![allow(non_snake_case)] // the paper's symbols

use std::ops::Range;

use anyhow::Result;
use clap::ValueEnum;
use cosim::run::Experiment;
use cosim::system::{Setting, System};
use rayon::prelude::*;
use serde::Serialize;

use crate::experiment::over;
use crate::laws::Law;
use crate::table::{SCALES, TRAJECTORIES};
use crate::tracking::{Bent, Tracking};

/// Largest error that the adaptive controller may have in the real world: median and worst RMSE of what it can know, m.
pub const TARGETS: [f64; 2] = [0.3e-3, 0.7e-3];
/// How many times smaller than that of the best rival with integral its median is to be.
pub const AHEAD: f64 = 1.5;

/// A world.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum World {
    /// The controller's own model, all inertias by one factor: a check of the code
    Ideal,
    /// A machine that the controller does not know: actuators as built, sensors, a step of delay, errors drawn by seed
    Real,
    /// A structure that bends, in MuJoCo, its errors drawn by seed; steps of at most 0.5 ms
    Bending,
}

/// A machine that the laws are tried on.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in the tables.
    pub label: String,
    /// Start values.
    pub settings: Vec<Setting>,
}

/// One run.
pub struct Cell {
    /// Name of the law.
    pub law: String,
    /// Name of the case.
    pub case: String,
    /// Trajectory.
    pub trajectory: &'static str,
    /// What came out, or why nothing did.
    pub result: Result<Tracking>,
}

/// The cases of a world: those of the ideal one are the inertia errors of the paper's table, those of the others a machine for each seed.
pub fn cases(world: World, system: &System, seeds: Range<u64>) -> Result<Cases> {
    match world {
        World::Ideal => Ok(Cases::plain(ideal_cases(system)?)),
        World::Real => Cases::drawn(system, seeds),
        World::Bending => Ok(Cases::plain(bending::cases(system, seeds)?)),
    }
}

fn ideal_cases(system: &System) -> Result<Vec<Case>> {
    let case = |scale: f64| {
        Ok(Case {
            label: format!("inertia {:+.0} %", 100.0 * (scale - 1.0)),
            settings: vec![system.setting("inertia_scale", scale)?],
        })
    };
    SCALES.into_iter().map(case).collect()
}

/// Run every law on every case and both trajectories in parallel; `done` is called after each run. A failed run keeps its error and the
/// others go on.
///
/// # Errors
/// A law that the controller does not have, or a start value of a case that is set already.
pub fn run(
    system: &System,
    base: &Experiment,
    laws: &[Law],
    cases: &[Case],
    done: impl Fn() + Sync,
) -> Result<Vec<Cell>> {
    let mut runs = Vec::new();
    for law in laws {
        let settings = law.settings(system)?;
        for (trajectory, _) in TRAJECTORIES {
            for case in cases {
                let motion = vec![system.setting("trajectory", trajectory)?];
                let varied = [case.settings.clone(), settings.clone(), motion].concat();
                let experiment = over(system, base, varied)?;
                runs.push((law, case, trajectory, experiment));
            }
        }
    }
    let one = |(law, case, trajectory, experiment): (&Law, &Case, &'static str, Experiment)| {
        let result = Tracking::of(system, &experiment);
        done();
        Cell {
            law: law.name.clone(),
            case: case.label.clone(),
            trajectory,
            result,
        }
    };
    Ok(runs.into_par_iter().map(one).collect())
}

/// Median and largest of a number over runs; infinite where a run failed, which counts as the worst.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Median; between the two in the middle where the count is even.
    pub median: f64,
    /// Largest.
    pub worst: f64,
}

impl Spread {
    /// Of these numbers; not a number where there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let Some(worst) = values.last().copied() else {
            return Self {
                median: f64::NAN,
                worst: f64::NAN,
            };
        };
        let n = values.len();
        let median = 0.5 * (values[(n - 1) / 2] + values[n / 2]);
        Self { median, worst }
    }
}

/// A law over all cases of a trajectory, or of both.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Law.
    pub law: String,
    /// RMSE of what the controller can know, m.
    pub known: Spread,
    /// Largest such error, m.
    pub known_max: Spread,
    /// RMSE at the true joint angles, m.
    pub joints: Spread,
    /// RMSE of the plant's tip, m.
    pub plant: Spread,
    /// The same without its mean, m.
    pub plant_varying: Spread,
    /// RMS of the orientation's error, rad.
    pub orientation: Spread,
    /// Largest known error over largest speed, s.
    pub rho: Spread,
    /// Largest distance of the plant's tip from where its joints say that it is, m; of a plant that bends.
    pub sag: Option<Spread>,
    /// Largest error against that place, m: dimensions as drawn count in it.
    pub rigid_max: Option<Spread>,
    /// Root mean square of that error less its mean, m.
    pub rigid_varying: Option<Spread>,
    /// Runs.
    pub runs: usize,
    /// Runs that failed.
    pub failed: usize,
}

impl Summary {
    fn of<'a>(law: &str, cells: impl Iterator<Item = &'a Cell> + Clone) -> Self {
        let spread = |of: &dyn Fn(&Tracking) -> f64| {
            let value = |c: &Cell| c.result.as_ref().map_or(f64::INFINITY, of);
            Spread::of(cells.clone().map(value))
        };
        let bends = cells
            .clone()
            .any(|c| c.result.as_ref().is_ok_and(|t| t.bent.is_some()));
        let bent = |of: &dyn Fn(&Bent) -> f64| {
            bends.then(|| spread(&|t| t.bent.as_ref().map_or(f64::INFINITY, of)))
        };
        Self {
            law: law.into(),
            known: spread(&|t| t.known.rmse),
            known_max: spread(&|t| t.known.max),
            joints: spread(&|t| t.joints.rmse),
            plant: spread(&|t| t.plant.rmse),
            plant_varying: spread(&|t| t.plant.varying),
            orientation: spread(&|t| t.orientation[0]),
            rho: spread(&Tracking::rho),
            sag: bent(&|b| b.sag_max),
            rigid_max: bent(&|b| b.rigid.max),
            rigid_varying: bent(&|b| b.rigid.varying),
            runs: cells.clone().count(),
            failed: cells.filter(|c| c.result.is_err()).count(),
        }
    }
}

/// Each law over the cases of `trajectory`, or of both, in the order of the runs.
pub fn summaries(cells: &[Cell], trajectory: Option<&str>) -> Vec<Summary> {
    let mut laws: Vec<&str> = Vec::new();
    for cell in cells {
        if !laws.contains(&cell.law.as_str()) {
            laws.push(&cell.law);
        }
    }
    let of = |law: &str| {
        let its = |c: &&Cell| c.law == law && trajectory.is_none_or(|t| t == c.trajectory);
        Summary::of(law, cells.iter().filter(its))
    };
    laws.into_iter().map(of).collect()
}

mod bending;
mod real;
mod text;

pub use bending::{SEEDS as BENDING_SEEDS, STEP as BENDING_STEP, SYSTEM as BENDING_SYSTEM};
pub use real::{Cases, PARAMETERS, SEEDS as REAL_SEEDS, SYSTEM, parameters_of};
pub use text::{bending_verdict, text, verdict, write_csv};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_worst() {
        let odd = Spread::of([3.0, 1.0, 2.0]);
        assert_eq!((odd.median, odd.worst), (2.0, 3.0));
        let even = Spread::of([4.0, 1.0, 2.0, f64::INFINITY]);
        assert_eq!((even.median, even.worst), (3.0, f64::INFINITY));
        assert!(Spread::of([]).median.is_nan());
    }
}
