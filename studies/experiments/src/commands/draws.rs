//! Subcommand `draws`: runs one control law on many randomly drawn machines.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};

use crate::analyses::draws::{self, Counts, FORCE_BOUND};
use crate::print::output::{conditions, finish, with_progress};
use crate::runs::grid::{Spread, TRAJECTORIES};
use crate::runs::run_store::RunStore;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{Law, MODES, is_path};
use crate::worlds::{World, cases};
use tip_path::BUILT_IN;

#[derive(Args)]
pub struct DrawsArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// World in which machines are drawn: real or strict-rigid
    #[arg(long, value_enum, default_value_t = World::Real)]
    world: World,
    /// Factor on the world's bounds of the machine's errors
    #[arg(long, default_value_t = 2.0, value_name = "FACTOR")]
    bounds: f64,
    /// First seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of machines
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Controller
    #[arg(long, value_parser = MODES, default_value = "adaptive_integral")]
    mode: String,
    /// Trajectory of the tip: cubic, triangular, or a path: a file or a built-in one, such as six-joints or iso9283-rectangle:6
    #[arg(long, value_parser = trajectory, default_value = "triangular")]
    trajectory: String,
    /// Keep runs in this folder and reuse those that are there, to continue an interrupted command
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// Also write all runs to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// A trajectory of the paper, or a path.
fn trajectory(text: &str) -> Result<String> {
    let is_known = TRAJECTORIES.contains(&text) || is_path(text);
    ensure!(
        is_known,
        "it must be {}, a built-in path ({}) or a file that there is",
        TRAJECTORIES.join(", "),
        BUILT_IN.join(", ")
    );
    Ok(text.into())
}

/// Counts the drawn machines that are kept, stopped and lost.
pub fn draws(args: &DrawsArgs) -> Result<Verdict> {
    ensure!(
        args.world.is_as_built(),
        "--world {}: machines are drawn within bounds only in the worlds real and strict-rigid",
        args.world.name()
    );
    let setup = args.machine.setup().world(args.world).build()?;
    let (system, base, mut verdict) = setup.into_parts();
    let mut found = conditions(&system, &base);
    let seeds = args.seed..args.seed + args.seeds;
    let cases = cases(args.world, &system, seeds, args.bounds)?;
    let law = &Law::new(&*args.mode, &args.mode);
    let store = RunStore::new(args.store.as_deref())?;
    let machine = (&system, &base);
    let runs = with_progress(args.seeds, "machines", |done| {
        draws::run(machine, law, &cases.list, &args.trajectory, &store, done)
    })?;
    let counts = Counts::from_runs(runs.iter().map(|draw| &draw.run));
    let (kept, stopped, lost, forced) = (counts.kept, counts.stopped, counts.lost, counts.forced);
    let force = Spread::from_values(runs.iter().map(|draw| draw.run.force));
    let error = Spread::from_values(runs.iter().filter_map(|draw| draw.run.rmse));
    print(format!(
        "{} machines, {} x the bounds of the {} world, {}, {}: {kept} kept, {stopped} stopped, {lost} lost\nrods with more than {FORCE_BOUND} x the largest \
         force asked for: on {forced} machines; largest force over that one: median {:.2}, worst {:.2}\nknown error of those kept: median {:.3} mm, worst {:.3} mm\n",
        args.seeds,
        args.bounds,
        args.world.name(),
        args.mode,
        args.trajectory,
        force.median,
        force.worst,
        1e3 * error.median,
        1e3 * error.worst,
    ))?;
    if let Some((medians, ratio)) = draws::laps(&runs) {
        let medians: Vec<_> = medians.iter().map(|m| format!("{:.3}", 1e3 * m)).collect();
        print(format!(
            "known error of each lap, median: {} mm; of the last over that of the first: median {:.2}, worst {:.2}\n",
            medians.join(", "),
            ratio.median,
            ratio.worst
        ))?;
    }
    draws::judge(&runs, &mut verdict);
    store.report_unused();
    found["bounds"] = args.bounds.into();
    found["counts"] = serde_json::to_value(counts)?;
    found["machines"] = serde_json::to_value(&runs)?;
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}
