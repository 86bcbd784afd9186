//! Subcommand `endurance`: a long coupled run that checks memory, time, tracking and estimates.

use anyhow::Result;
use clap::Args;
use cosim::Verdict;
use cosim::cli::print;

use crate::analyses::endurance::{self, Excursion, Part};
use crate::print::output::print_counted;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{MODES, vary};

#[derive(Args)]
pub struct EnduranceArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Communication steps; 10000000 of 1 ms are 2.8 h of simulated time
    #[arg(long, default_value_t = 1_000_000)]
    steps: u64,
    /// Edges of the box that the tip moves through, from its start position, m, world frame
    #[arg(long, default_values_t = [-0.2, 0.2, 0.2], num_args = 3, value_names = ["X", "Y", "Z"], allow_negative_numbers = true)]
    edges: Vec<f64>,
    /// Period of the motion along X, s; those along Y and Z are sqrt(2) and 1.618 times as long
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    period: f64,
    /// Controller
    #[arg(long, value_parser = MODES, default_value = "adaptive")]
    mode: String,
    /// Factor on mass and inertia of all bodies of the manipulator (not of the controller's model)
    #[arg(long, value_name = "FACTOR", default_value_t = 1.2)]
    inertia_scale: f64,
}

/// Runs the machine for a long time and prints a row for each part of the run.
pub fn endurance(args: &EnduranceArgs) -> Result<Verdict> {
    let (system, base, mut verdict) = args.machine.setup().build()?.into_parts();
    anyhow::ensure!(
        base.stop.is_none(),
        "--stop-time cannot be used here: --steps gives the length of the run"
    );
    let experiment = vary(
        &system,
        &base,
        &[
            ("mode", &args.mode),
            ("inertia_scale", &args.inertia_scale),
            ("lyapunov.inertia_scale", &args.inertia_scale),
        ],
    )?;
    let excursion = Excursion::new([args.edges[0], args.edges[1], args.edges[2]], args.period)?;
    print(Part::TITLES)?;
    let each = |part: &Part| print(part.row() + "\n");
    let endurance = endurance::run(&system, &experiment, &excursion, args.steps, each)?;
    print(endurance.summary())?;
    endurance.check()?;
    verdict.extend(endurance.limits);
    print_counted(&verdict, args.machine.check())?;
    Ok(verdict)
}
