//! Subcommand `compare`: runs one trajectory with the three controllers of the paper's table.

use std::fmt::{Display, Write as _};
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use cosim::cli::{CsvArgs, print};
use cosim::{Recording, Verdict};

use super::run::logged_run;
use crate::analyses::inertia::{self, MODES};
use crate::print::output::verdict_text;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::vary;

#[derive(Args)]
pub struct CompareArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Reference trajectory
    #[arg(long, value_parser = ["cubic", "triangular"], default_value = "cubic", conflicts_with = "waypoints")]
    trajectory: String,
    /// Factor on mass and inertia of all bodies of the manipulator (not of the controller's model)
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    inertia_scale: f64,
    /// Write signals of each run to TRAJECTORY_CONTROLLER.csv in this directory
    #[arg(long, value_name = "DIR")]
    csv_dir: Option<PathBuf>,
    /// Time between rows, s, a multiple of the communication step [default: the communication step]
    #[arg(long, value_name = "SECONDS", requires = "csv_dir")]
    interval: Option<f64>,
}

/// Runs the three controllers on one trajectory.
pub fn compare(args: &CompareArgs) -> Result<Verdict> {
    let (system, base, mut verdict) = args.machine.setup().build()?.into_parts();
    let scale = args.inertia_scale;
    // The setup has set the path already; its name may contain folders.
    let (title, stem, trajectory) = match &args.machine.waypoints {
        Some(path) => (format!("path {path}"), "path", None),
        None => {
            let title = format!("{} trajectory", args.trajectory);
            (title, &*args.trajectory, Some(&args.trajectory))
        }
    };
    let mut rows = Vec::new();
    for mode in MODES {
        eprintln!("{title}, controller {mode}, inertia x {scale}");
        let mut values: Vec<(_, &dyn Display)> = vec![("mode", &mode), ("inertia_scale", &scale)];
        values.extend(trajectory.map(|trajectory| ("trajectory", trajectory as _)));
        let experiment = vary(&system, &base, &values)?;
        let file = |dir: &PathBuf| dir.join(format!("{stem}_{mode}.csv"));
        let csv = CsvArgs {
            csv: args.csv_dir.as_ref().map(file),
            signals: Vec::new(),
            interval: args.interval,
        };
        let (outcome, accuracy) =
            logged_run(&system, &experiment, &csv, &mut None::<Recording>, false)?;
        verdict.extend(outcome.verdict().prefixed(mode));
        rows.push((mode, outcome, accuracy, csv.csv));
    }
    let mut text = format!(
        "\ntip error over the {title}, inertia x {scale}, H = {} s, in mm\n{:<12}{:>10}{:>10}{:>14}{:>16}\n",
        base.stepping.step, "controller", "RMSE", "max", "paper, RMSE", "x real time"
    );
    for (mode, outcome, ..) in &rows {
        let tip = outcome.tip.motion;
        let paper = trajectory.filter(|_| *mode == "adaptive");
        let paper = paper.and_then(|trajectory| inertia::paper(trajectory, scale));
        let paper = paper.map_or("-".into(), |m| format!("{:.1}", 1e3 * m));
        let (rms, max) = (1e3 * tip.rms(), 1e3 * tip.max);
        let factor = outcome.run.real_time_factor();
        writeln!(
            text,
            "{mode:<12}{rms:>10.4}{max:>10.4}{paper:>14}{factor:>16.0}"
        )?;
    }
    for (mode, _, accuracy, _) in &rows {
        if let Some(accuracy) = accuracy {
            write!(text, "{mode}: {accuracy}")?;
        }
    }
    for path in rows.iter().filter_map(|(.., csv)| csv.as_ref()) {
        writeln!(text, "signals written to {}", path.display())?;
    }
    print(text + &verdict_text(&verdict))?;
    Ok(verdict)
}
