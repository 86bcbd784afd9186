//! Subcommand `stability`: the stability proof in numbers, or the causes that exceed its bound.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};

use crate::analyses::stability::{self, causes, compliance};
use crate::print::output::{conditions, finish, with_progress};
use crate::print::stability::{causes_text, text, unfitted_text};
use crate::setup::machine_choice::MachineFile;
use crate::setup::run_setup::MachineArgs;
use crate::worlds::World;

#[derive(Args)]
pub struct StabilityArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Plant and sensors; real: how much each cause contributes to exceeding the bound, though drives with current loops do not follow the
    /// paper's voltage law
    #[arg(long, value_enum, default_value_t = World::Ideal)]
    world: World,
    /// Factor on mass and inertia of all bodies of the manipulator (not of the controller's model)
    #[arg(long, value_name = "FACTOR", default_value_t = 1.4)]
    inertia_scale: f64,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// Prints the proof in numbers, or in the real world the causes that exceed its bound.
pub fn stability(args: &StabilityArgs) -> Result<Verdict> {
    anyhow::ensure!(
        matches!(args.world, World::Ideal | World::Real),
        "--world {}: the accompanying functions need the plant's inertias, which only the ideal and the real world provide",
        args.world.name()
    );
    let setup = args.machine.setup().world(args.world).build()?;
    let (system, base, mut verdict) = setup.into_parts();
    let mut found = conditions(&system, &base);
    if args.world == World::Real {
        let (rungs, found_in_runs) = causes(&system, &base, args.inertia_scale)?;
        verdict.extend(found_in_runs);
        print(causes_text(&rungs))?;
        found["causes"] = serde_json::to_value(&rungs)?;
    } else {
        let (runs, found_in_runs) = with_progress(stability::RUNS, "runs", |done| {
            stability::run(&system, &base, args.inertia_scale, done)
        })?;
        let runs = runs.into_iter().collect::<Result<Vec<_>>>()?;
        verdict.extend(found_in_runs);
        stability::judge(&runs, &mut verdict);
        let scale = format!("inertia x {}\n", args.inertia_scale);
        print(scale + &text(&runs))?;
        let file = MachineFile::from_manipulator(&system, &base.settings)?;
        let emla = file.machine.emla.lift;
        let compliance = compliance(&system, &base, &emla)?;
        print(unfitted_text(&runs[0].gains, compliance, emla.L_d))?;
        found["inertia_scale"] = args.inertia_scale.into();
        found["stability"] = serde_json::to_value(&runs)?;
    }
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}
