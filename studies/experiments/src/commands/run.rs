//! Subcommand `run`: one run, its tip error, residuals, accuracy and verdict; `compare` runs alike.

use std::fmt::Display;

use anyhow::{Context as _, Result};
use clap::Args;
use cosim::cli::{CsvArgs, bar, keep_rows, keep_rows_in, output, print};
use cosim::run::observer::{Function, Observer, Observers};
use cosim::{Experiment, Master, System, Verdict};

use crate::measures::iso9283::{Measures, Meter};
use crate::measures::run::{FailedRun, Outcome, default_signals, run as run_once};
use crate::print::output::verdict_text;
use crate::runs::mcap::Recorder;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{MODES, vary};

#[derive(Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Reference trajectory
    #[arg(long, value_parser = ["cubic", "triangular", "external"], conflicts_with = "waypoints")]
    trajectory: Option<String>,
    /// Controller
    #[arg(long, value_parser = MODES)]
    mode: Option<String>,
    /// Factor on mass and inertia of all bodies of the manipulator (not of the controller's model)
    #[arg(long, value_name = "FACTOR")]
    inertia_scale: Option<f64>,
    #[command(flatten)]
    csv: CsvArgs,
    /// Record poses of all bodies, signals and findings as MCAP, for Foxglove and rerun
    #[arg(long, value_name = "FILE", value_parser = output(), group = "rows")]
    mcap: Option<std::path::PathBuf>,
    /// Largest tip error over the motion for a good verdict, m
    #[arg(long, value_name = "METRES")]
    max_error: Option<f64>,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

/// Runs one experiment and prints its results.
pub fn run(args: &RunArgs) -> Result<Verdict> {
    let (system, base, mut verdict) = args.machine.setup().build()?.into_parts();
    let mut values: Vec<(_, &dyn Display)> = Vec::new();
    values.extend(args.trajectory.iter().map(|v| ("trajectory", v as _)));
    values.extend(args.mode.iter().map(|v| ("mode", v as _)));
    let scale = args.inertia_scale.iter();
    values.extend(scale.map(|v| ("inertia_scale", v as _)));
    let experiment = vary(&system, &base, &values)?;
    let mut recorder = args.recorder(&system, &experiment)?;
    let done = logged_run(&system, &experiment, &args.csv, &mut recorder, args.quiet);
    if let Ok((outcome, _)) = &done {
        verdict.extend(outcome.verdict());
        verdict.extend(outcome.tip.verdict(args.max_error));
    }
    let done = match (&args.mcap, recorder) {
        (Some(path), Some(recorder)) => {
            let kept = recorder.finish(done.as_ref().map(|_| &verdict));
            keep_rows_in(path, kept, done)
        }
        _ => done,
    };
    let (outcome, accuracy) = done?;
    let accuracy = accuracy.map_or(String::new(), |measures| measures.to_string());
    print(outcome.summary() + &accuracy + &verdict_text(&verdict))?;
    for path in args.csv.csv.iter().chain(&args.mcap) {
        print(format_args!("signals written to {}\n", path.display()))?;
    }
    Ok(verdict)
}

impl RunArgs {
    fn recorder(&self, system: &System, experiment: &Experiment) -> Result<Option<Recorder>> {
        let Some(path) = &self.mcap else {
            return Ok(None);
        };
        let ports = self.csv.ports(system, || default_signals(system))?;
        let made = Recorder::create(path, system, experiment, &ports, self.csv.interval);
        made.context("--mcap").map(Some)
    }
}

/// Runs with a progress bar, the accuracy on an ISO 9283 path and, if asked for, a CSV file.
pub(super) fn logged_run(
    system: &System,
    experiment: &Experiment,
    csv: &CsvArgs,
    recorder: &mut dyn Observer,
    quiet: bool,
) -> Result<(Outcome, Option<Measures>)> {
    let mut meter = Meter::from_experiment(system, experiment)?;
    let mut log = csv.log(system, experiment, false, || default_signals(system))?;
    let bar = bar(0, "steps", quiet);
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let measure = |master: &Master| meter.iter_mut().try_for_each(|meter| meter.add(master));
    let measure = &mut Function(measure);
    let observers = &mut Observers(vec![measure, &mut log, recorder]);
    let outcome = run_once(system, experiment, &progress, observers);
    bar.finish_and_clear();
    let outcome = keep_rows(log, outcome.map_err(FailedRun::explain))?;
    Ok((outcome, meter.and_then(|meter| meter.measures())))
}
