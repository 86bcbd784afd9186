//! Subcommands `run` and `compare`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use cosim::cli::{bar, create};
use cosim::run::Experiment;
use cosim::signals::{CsvLog, Signals, matching, titles};
use cosim::system::System;
use studies::experiment::{self, Outcome, vary};
use studies::table;

use super::MachineArgs;

#[derive(Args)]
pub struct RunArgs {
    #[command(flatten)]
    machine: MachineArgs,
    /// Reference trajectory
    #[arg(long, value_parser = ["cubic", "triangular", "external"])]
    trajectory: Option<String>,
    /// Controller
    #[arg(long, value_parser = ["adaptive", "modular", "pd"])]
    mode: Option<String>,
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal ones)
    #[arg(long, value_name = "FACTOR")]
    inertia_scale: Option<f64>,
    /// Write signals at every communication point to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Signals for --csv, comma-separated, * as wildcard: `hdrm.tip.*,*.F` [default: all outputs]
    #[arg(long, value_delimiter = ',', value_name = "PATTERNS", requires = "csv")]
    signals: Vec<String>,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
pub struct CompareArgs {
    #[command(flatten)]
    machine: MachineArgs,
    /// Reference trajectory
    #[arg(long, value_parser = ["cubic", "triangular"], default_value = "cubic")]
    trajectory: String,
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal ones)
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    inertia_scale: f64,
    /// Write all outputs of each run to TRAJECTORY_CONTROLLER.csv in this directory
    #[arg(long, value_name = "DIR")]
    csv_dir: Option<PathBuf>,
}

pub fn run(args: &RunArgs) -> Result<()> {
    let (system, mut experiment) = args.machine.load()?;
    if let Some(trajectory) = &args.trajectory {
        experiment = vary(&system, &experiment, &[("trajectory", trajectory)])?;
    }
    if let Some(mode) = &args.mode {
        experiment = vary(&system, &experiment, &[("mode", mode)])?;
    }
    if let Some(scale) = &args.inertia_scale {
        experiment = vary(&system, &experiment, &[("inertia_scale", scale)])?;
    }
    let csv = args.csv.as_deref();
    let outcome = shown(&system, &experiment, &args.signals, csv, args.quiet)?;
    print!("{}", outcome.summary());
    if let Some(path) = &args.csv {
        println!("signals written to {}", path.display());
    }
    Ok(())
}

/// Run with a progress bar and, where asked for, a CSV file.
fn shown(
    system: &System,
    experiment: &Experiment,
    patterns: &[String],
    csv: Option<&Path>,
    quiet: bool,
) -> Result<Outcome> {
    let bar = bar(0, "steps", quiet);
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let Some(path) = csv else {
        let outcome = experiment::run(system, experiment, &progress, |_| Ok(()));
        bar.finish_and_clear();
        return outcome;
    };
    let ports = matching(system, patterns)?;
    let mut signals = Signals::new(system, &ports)?;
    let mut log = CsvLog::new(create(path)?, &titles(system, &ports))?;
    let outcome = experiment::run(system, experiment, &progress, |master| {
        log.row(master.time(), signals.read(master)?)
    })?;
    bar.finish_and_clear();
    log.finish()?;
    Ok(outcome)
}

pub fn compare(args: &CompareArgs) -> Result<()> {
    let (system, base) = args.machine.load()?;
    let scale = args.inertia_scale;
    let mut rows = Vec::new();
    for mode in table::MODES {
        eprintln!(
            "{} trajectory, controller {mode}, inertia x {scale}",
            args.trajectory
        );
        let experiment = vary(
            &system,
            &base,
            &[
                ("trajectory", &args.trajectory),
                ("mode", &mode),
                ("inertia_scale", &scale),
            ],
        )?;
        let name = format!("{}_{mode}.csv", args.trajectory);
        let csv = args.csv_dir.as_ref().map(|dir| dir.join(name));
        rows.push((
            mode,
            shown(&system, &experiment, &[], csv.as_deref(), false)?,
            csv,
        ));
    }
    println!(
        "\ntip error over the {} trajectory, inertia x {scale}, H = {} s, in mm",
        args.trajectory, base.stepping.step
    );
    println!(
        "{:<12}{:>10}{:>10}{:>14}{:>16}",
        "controller", "RMSE", "max", "paper, RMSE", "x real time"
    );
    for (mode, outcome, _) in &rows {
        let tip = outcome.tip.motion;
        let paper = table::paper(&args.trajectory, scale, mode)
            .map_or("-".into(), |m| format!("{:.1}", 1e3 * m));
        println!(
            "{mode:<12}{:>10.4}{:>10.4}{paper:>14}{:>16.0}",
            1e3 * tip.rms(),
            1e3 * tip.max,
            outcome.run.real_time_factor()
        );
    }
    for path in rows.iter().filter_map(|(.., csv)| csv.as_ref()) {
        println!("signals written to {}", path.display());
    }
    Ok(())
}
