//! Subcommands `run` and `compare`.

use std::fmt::Write as _;
use std::path::PathBuf;

use crate::accuracy::{Measures, Meter};
use crate::experiment::{Outcome, vary};
use crate::laws;
use crate::table;
use crate::verdict;
use crate::watched::{self, useful};
use anyhow::Result;
use clap::Args;
use cosim::cli::{CsvArgs, bar, print};
use cosim::run::Experiment;
use cosim::system::System;
use cosim::verdict::Verdict;

use super::MachineArgs;

#[derive(Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Reference trajectory
    #[arg(long, value_parser = ["cubic", "triangular", "external"], conflicts_with = "waypoints")]
    trajectory: Option<String>,
    /// Controller
    #[arg(long, value_parser = laws::MODES)]
    mode: Option<String>,
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal ones)
    #[arg(long, value_name = "FACTOR")]
    inertia_scale: Option<f64>,
    #[command(flatten)]
    csv: CsvArgs,
    /// Largest tip error over the motion with which the verdict is good, m
    #[arg(long, value_name = "METRES")]
    max_error: Option<f64>,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
pub struct CompareArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Reference trajectory
    #[arg(long, value_parser = ["cubic", "triangular"], default_value = "cubic", conflicts_with = "waypoints")]
    trajectory: String,
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal ones)
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    inertia_scale: f64,
    /// Write signals of each run to TRAJECTORY_CONTROLLER.csv in this directory
    #[arg(long, value_name = "DIR")]
    csv_dir: Option<PathBuf>,
    /// Time from row to row, s, a multiple of the communication step [default: the communication step]
    #[arg(long, value_name = "SECONDS", requires = "csv_dir")]
    interval: Option<f64>,
}

/// One experiment.
pub fn run(args: &RunArgs) -> Result<Verdict> {
    let (system, mut experiment, mut verdict) = args.machine.load()?;
    if let Some(trajectory) = &args.trajectory {
        experiment = vary(&system, &experiment, &[("trajectory", trajectory)])?;
    }
    if let Some(mode) = &args.mode {
        experiment = vary(&system, &experiment, &[("mode", mode)])?;
    }
    if let Some(scale) = &args.inertia_scale {
        experiment = vary(&system, &experiment, &[("inertia_scale", scale)])?;
    }
    let (outcome, seen, accuracy) = watched(&system, &experiment, &args.csv, args.quiet)?;
    verdict.extend(outcome.run.verdict.clone());
    verdict.extend(seen);
    verdict.extend(verdict::tracking(&outcome.tip, args.max_error));
    let accuracy = accuracy.map_or(String::new(), |measures| measures.to_string());
    print(format_args!("{}{accuracy}{verdict}", outcome.summary()))?;
    if let Some(path) = &args.csv.csv {
        print(format_args!("signals written to {}\n", path.display()))?;
    }
    Ok(verdict)
}

/// Run with a progress bar, the machine's limits watched, the accuracy on a test path measured, and, where asked for, a CSV file.
fn watched(
    system: &System,
    experiment: &Experiment,
    csv: &CsvArgs,
    quiet: bool,
) -> Result<(Outcome, Verdict, Option<Measures>)> {
    let mut meter = Meter::of(system, experiment)?;
    let mut log = csv.log(system, experiment, || useful(system))?;
    let bar = bar(0, "steps", quiet);
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let watched = watched::run(system, experiment, &progress, |master| {
        meter.iter_mut().try_for_each(|meter| meter.add(master))?;
        log.iter_mut().try_for_each(|log| log.add(master))
    });
    bar.finish_and_clear();
    let (outcome, seen) = watched?;
    log.map_or(Ok(()), |log| log.finish())?;
    Ok((outcome, seen, meter.and_then(|meter| meter.measures())))
}

/// The three controllers on one trajectory.
pub fn compare(args: &CompareArgs) -> Result<Verdict> {
    let (system, base, mut verdict) = args.machine.load()?;
    let scale = args.inertia_scale;
    // A path was set already, and has a name that may hold folders.
    let (title, stem, trajectory) = match args.machine.waypoints() {
        Some(path) => (format!("path {path}"), "path", None),
        None => {
            let title = format!("{} trajectory", args.trajectory);
            (title, &*args.trajectory, Some(&args.trajectory))
        }
    };
    let mut rows = Vec::new();
    for mode in table::MODES {
        eprintln!("{title}, controller {mode}, inertia x {scale}");
        let mut experiment = vary(
            &system,
            &base,
            &[("mode", &mode), ("inertia_scale", &scale)],
        )?;
        if let Some(trajectory) = trajectory {
            experiment = vary(&system, &experiment, &[("trajectory", trajectory)])?;
        }
        let name = format!("{stem}_{mode}.csv");
        let csv = CsvArgs {
            csv: args.csv_dir.as_ref().map(|dir| dir.join(name)),
            signals: Vec::new(),
            interval: args.interval,
        };
        let (outcome, seen, accuracy) = watched(&system, &experiment, &csv, false)?;
        verdict.extend(outcome.run.verdict.clone().of(mode));
        verdict.extend(seen.of(mode));
        rows.push((mode, outcome, accuracy, csv.csv));
    }
    let mut text = format!(
        "\ntip error over the {title}, inertia x {scale}, H = {} s, in mm\n{:<12}{:>10}{:>10}{:>14}{:>16}\n",
        base.stepping.step, "controller", "RMSE", "max", "paper, RMSE", "x real time"
    );
    for (mode, outcome, ..) in &rows {
        let tip = outcome.tip.motion;
        let paper = trajectory.and_then(|trajectory| table::paper(trajectory, scale, mode));
        let paper = paper.map_or("-".into(), |m| format!("{:.1}", 1e3 * m));
        writeln!(
            text,
            "{mode:<12}{:>10.4}{:>10.4}{paper:>14}{:>16.0}",
            1e3 * tip.rms(),
            1e3 * tip.max,
            outcome.run.real_time_factor()
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
    print(format_args!("{text}{verdict}"))?;
    Ok(verdict)
}
