//! Subcommand `run`.

use anyhow::Result;
use clap::Args;
use cosim::cli::{CsvArgs, bar, print};
use cosim::{Experiment, System, Verdict};

use crate::measures::iso9283::{Measures, Meter};
use crate::measures::run::{FailedRun, Outcome, run as run_once, useful};
use crate::print::output::verdict_text;
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
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal
    /// ones)
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

/// One experiment.
pub fn run(args: &RunArgs) -> Result<Verdict> {
    let (system, mut experiment, mut verdict) = args.machine.setup().build()?.into_parts();
    if let Some(trajectory) = &args.trajectory {
        experiment = vary(&system, &experiment, &[("trajectory", trajectory)])?;
    }
    if let Some(mode) = &args.mode {
        experiment = vary(&system, &experiment, &[("mode", mode)])?;
    }
    if let Some(scale) = &args.inertia_scale {
        experiment = vary(&system, &experiment, &[("inertia_scale", scale)])?;
    }
    let (outcome, accuracy) = logged_run(&system, &experiment, &args.csv, args.quiet)?;
    verdict.extend(outcome.verdict());
    verdict.extend(outcome.tip.verdict(args.max_error));
    let accuracy = accuracy.map_or(String::new(), |measures| measures.to_string());
    print(format_args!(
        "{}{accuracy}{}",
        outcome.summary(),
        verdict_text(&verdict)
    ))?;
    if let Some(path) = &args.csv.csv {
        print(format_args!("signals written to {}\n", path.display()))?;
    }
    Ok(verdict)
}

/// Run with a progress bar, the accuracy on a test path measured, and, where asked for, a CSV file.
pub(super) fn logged_run(
    system: &System,
    experiment: &Experiment,
    csv: &CsvArgs,
    quiet: bool,
) -> Result<(Outcome, Option<Measures>)> {
    let mut meter = Meter::of(system, experiment)?;
    let mut log = csv.log(system, experiment, false, || useful(system))?;
    let bar = bar(0, "steps", quiet);
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let outcome = run_once(system, experiment, &progress, |master| {
        meter.iter_mut().try_for_each(|meter| meter.add(master))?;
        log.iter_mut().try_for_each(|log| log.add(master))
    });
    bar.finish_and_clear();
    let outcome = outcome.map_err(FailedRun::explained)?;
    log.map_or(Ok(()), |log| log.finish())?;
    Ok((outcome, meter.and_then(|meter| meter.measures())))
}
