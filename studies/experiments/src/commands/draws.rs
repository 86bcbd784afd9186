//! Subcommand `draws`: many machines drawn at random under one law.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use cosim::Verdict;
use cosim::cli::print;

use crate::analyses::draws::{self, Counts, FORCE_BOUND};
use crate::print::output::{conditions, finish, with_progress};
use crate::runs::grid::{ALL_TRAJECTORIES, Spread};
use crate::runs::run_store::RunStore;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{Law, MODES};
use crate::worlds::{World, cases};

#[derive(Args)]
pub struct DrawsArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// World that machines are drawn in: real or strict-rigid
    #[arg(long, value_enum, default_value_t = World::Real)]
    world: World,
    /// Bounds of the machine's errors over those of the world
    #[arg(long, default_value_t = 2.0, value_name = "FACTOR")]
    bounds: f64,
    /// First seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Machines
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Controller
    #[arg(long, value_parser = MODES, default_value = "adaptive_integral")]
    mode: String,
    /// What the tip follows
    #[arg(long, value_parser = ALL_TRAJECTORIES, default_value = "triangular")]
    trajectory: String,
    /// Keep each run in this folder, and take those that are there: an interrupted command goes on
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// Also write all runs to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// How many drawn machines are kept, stopped and lost.
pub fn draws(args: &DrawsArgs) -> Result<Verdict> {
    ensure!(
        args.world.is_as_built(),
        "--world {}: machines are drawn within bounds in the worlds real and strict-rigid",
        args.world.name()
    );
    let setup = args.machine.setup().world(args.world).build()?;
    let (system, base, mut verdict) = setup.into_parts();
    let mut found = conditions(&system, &base);
    let seeds = args.seed..args.seed + args.seeds;
    let cases = cases(args.world, &system, seeds, args.bounds)?;
    let law = &Law::new(&*args.mode, &args.mode);
    let store = RunStore::new(args.store.as_deref(), &system)?;
    let of = (&system, &base);
    let runs = with_progress(args.seeds, "machines", |done| {
        draws::run(of, law, &cases.list, &args.trajectory, &store, done)
    })?;
    let counts = Counts::from_runs(runs.iter().map(|draw| &draw.run));
    let force = Spread::of(runs.iter().map(|draw| draw.run.force));
    let error = Spread::of(runs.iter().filter_map(|draw| draw.run.rmse));
    print(format!(
        "{} machines, {} x the bounds of the {} world, {}, {}: {} kept, {} stopped, {} lost\nrods with more than {FORCE_BOUND} x the largest \
         force asked for: on {} machines; largest force over that one: median {:.2}, worst {:.2}\nknown error of those kept: median {:.3} mm, worst {:.3} mm\n",
        args.seeds,
        args.bounds,
        args.world.name(),
        args.mode,
        args.trajectory,
        counts.kept,
        counts.stopped,
        counts.lost,
        counts.forced,
        force.median,
        force.worst,
        1e3 * error.median,
        1e3 * error.worst,
    ))?;
    draws::judge(&runs, &mut verdict);
    found["bounds"] = args.bounds.into();
    found["counts"] = serde_json::to_value(counts)?;
    found["machines"] = serde_json::to_value(&runs)?;
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}
