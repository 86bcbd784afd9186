//! The paper's robustness table `tab:rmse_uncertainties`: tip RMSE under inertia errors for both trajectories, here for three controllers.

use std::fmt::{Display, Write as _};

use anyhow::Result;
use cosim::run::Experiment;
use cosim::system::System;
use rayon::prelude::*;

use crate::experiment::{self, vary};
use crate::tip::TipError;

/// Inertia scales, in the paper's order.
pub const SCALES: [f64; 5] = [1.4, 1.2, 1.0, 0.8, 0.6];
/// Controllers, in the order of the columns.
pub const MODES: [&str; 3] = ["adaptive", "modular", "pd"];
/// A trajectory and the paper's RMSE of its adaptive controller for [`SCALES`], m.
pub const TRAJECTORIES: [(&str, [f64; 5]); 2] = [
    ("cubic", [0.0024, 0.0019, 0.0015, 0.0029, 0.0036]),
    ("triangular", [0.0042, 0.0035, 0.0029, 0.0050, 0.0060]),
];

/// The paper's RMSE for these conditions, m, where it gives one.
pub fn paper(trajectory: &str, scale: f64, mode: &str) -> Option<f64> {
    let (_, column) = TRAJECTORIES.iter().find(|(name, _)| *name == trajectory)?;
    let row = SCALES.iter().position(|s| (s - scale).abs() < 1e-9)?;
    (mode == "adaptive").then_some(column[row])
}

/// One cell: its conditions and the tip error, or why there is none.
pub struct Cell {
    /// Trajectory.
    pub trajectory: &'static str,
    /// Scale of all inertias of the manipulator.
    pub scale: f64,
    /// Controller.
    pub mode: &'static str,
    /// The paper's RMSE of the adaptive controller in this row, m.
    pub paper: f64,
    /// Tip error, or the failure.
    pub result: Result<TipError>,
}

/// Number of cells.
pub const CELLS: usize = TRAJECTORIES.len() * SCALES.len() * MODES.len();

/// Run all cells under `base` in parallel; `done` is called after each. A failed cell keeps its error and the others go on.
///
/// # Errors
/// `base` sets what is varied here; this is found before the first run.
pub fn run(system: &System, base: &Experiment, done: impl Fn() + Sync) -> Result<Vec<Cell>> {
    let mut planned = Vec::new();
    for (trajectory, paper) in TRAJECTORIES {
        for (scale, paper) in SCALES.into_iter().zip(paper) {
            for mode in MODES {
                let values: [(_, &dyn Display); 3] = [
                    ("trajectory", &trajectory),
                    ("mode", &mode),
                    ("inertia_scale", &scale),
                ];
                let experiment = vary(system, base, &values)?;
                planned.push((trajectory, scale, mode, paper, experiment));
            }
        }
    }
    let run_one = |(trajectory, scale, mode, paper, experiment)| {
        let outcome = experiment::run(system, &experiment, &|_, _| (), |_| Ok(()));
        done();
        Cell {
            trajectory,
            scale,
            mode,
            paper,
            result: outcome.map(|outcome| outcome.tip),
        }
    };
    Ok(planned.into_par_iter().map(run_one).collect())
}

/// The cells as a table for people, RMSE and maximum in mm, then the failures.
pub fn text(cells: &[Cell]) -> String {
    let mut text = format!("{:<11}{:>8}", "trajectory", "inertia");
    let mut failures = String::new();
    for mode in MODES {
        write!(text, "{:>20}", format!("{mode} (max)")).expect("a String takes every text");
    }
    text += &format!("{:>16}\n", "paper, adaptive");
    for row in cells.chunks(MODES.len()) {
        text += &format!(
            "{:<11}{:>7.0}%",
            row[0].trajectory,
            100.0 * (row[0].scale - 1.0)
        );
        for c in row {
            text += &match &c.result {
                Ok(tip) => format!(
                    "{:>20}",
                    format!(
                        "{:.3} ({:.3})",
                        1e3 * tip.motion.rms(),
                        1e3 * tip.motion.max
                    )
                ),
                Err(_) => format!("{:>20}", "failed"),
            };
            if let Err(error) = &c.result {
                failures += &format!(
                    "{} {} at inertia x {}: {error:#}\n",
                    c.trajectory, c.mode, c.scale
                );
            }
        }
        text += &format!("{:>16.1}\n", 1e3 * row[0].paper);
    }
    text + "tip RMSE and maximum in mm over the motion\n" + &failures
}

/// The cells as comma-separated values.
pub fn write_csv(cells: &[Cell], out: &mut impl std::io::Write) -> Result<()> {
    writeln!(
        out,
        "trajectory,inertia_scale,mode,rmse [m],max [m],rmse whole run [m],paper adaptive rmse [m]"
    )?;
    for c in cells {
        let values = c.result.as_ref().map_or([f64::NAN; 3], |tip| {
            [tip.motion.rms(), tip.motion.max, tip.whole.rms()]
        });
        writeln!(
            out,
            "{},{},{},{},{},{},{}",
            c.trajectory, c.scale, c.mode, values[0], values[1], values[2], c.paper
        )?;
    }
    Ok(())
}
