//! Subcommand `rest`: whether the machine rests in any pose, with any payload.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};

use crate::analyses::rest::{self, Follows, LOADS, Rest};
use crate::print::output::{conditions, finish, with_progress, write};
use crate::runs::run_store::RunStore;
use crate::setup::machine_choice::MachineFile;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{MODES, laws_of_modes};
use crate::worlds::World;

/// Laws that are judged at all poses under commanded rates, and those at a fifth of them.
const LAWS: [&str; 2] = ["adaptive", "adaptive_integral"];
const OTHERS: [&str; 4] = [
    "modular",
    "modular_integral",
    "pd_gravity",
    "pd_gravity_integral",
];
/// Share of the poses for paths, and for other laws.
const FEWER: usize = 5;

#[derive(Args)]
pub struct RestArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Laws, repeatable [default: adaptive, adaptive_integral, and at a fifth of the poses modular,
    /// modular_integral, pd_gravity, pd_gravity_integral]
    #[arg(long = "law", value_name = "MODE", value_parser = MODES)]
    laws: Vec<String>,
    /// Worlds, repeatable: ideal or real [default: both]
    #[arg(long = "world", value_enum)]
    worlds: Vec<World>,
    /// What is followed, repeatable [default: rates, and at a fifth of the poses a path]
    #[arg(long = "follows", value_enum)]
    follows: Vec<Follows>,
    /// Number of random poses
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    poses: u32,
    /// Seed of the poses
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Keep runs in this folder and reuse those that are there, to continue an interrupted command
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// Also write all runs to this CSV file
    #[arg(long, value_name = "FILE", value_parser = output())]
    csv: Option<PathBuf>,
    /// Also write all runs to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// Prints how many machines rest, by world, reference and law.
pub fn rest(args: &RestArgs) -> Result<Verdict> {
    let worlds = match &args.worlds[..] {
        [] => &[World::Ideal, World::Real],
        worlds => worlds,
    };
    let all = args.poses as usize;
    let mut verdict = Verdict::default();
    let (mut rests, mut found) = (Vec::new(), None);
    let store = RunStore::new(args.store.as_deref())?;
    for world in worlds {
        ensure!(
            matches!(world, World::Ideal | World::Real),
            "--world {}: machines are left at rest in the worlds ideal and real",
            world.name()
        );
        let (system, base, mentions) = args.machine.setup().world(*world).build()?.into_parts();
        verdict.extend(mentions);
        ensure!(
            base.stop.is_none(),
            "--stop-time cannot be used here: the study sets the length of each run"
        );
        found.get_or_insert_with(|| conditions(&system, &base));
        let file = MachineFile::from_manipulator(&system, &base.settings)?;
        let poses = rest::poses(&file.machine, args.seed, all)?;
        let modes: Vec<&str> = match &args.laws[..] {
            [] => LAWS.into_iter().chain(OTHERS).collect(),
            laws => laws.iter().map(String::as_str).collect(),
        };
        let follows = match &args.follows[..] {
            [] => &[Follows::Rates, Follows::Path],
            follows => follows,
        };
        for follows in follows {
            for law in laws_of_modes(&modes) {
                let is_whole = *follows == Follows::Rates && LAWS.contains(&&*law.name);
                let count = if is_whole { all } else { all.div_ceil(FEWER) };
                let runs = (LOADS.len() * count) as u64;
                let machine = (&system, &base, *world);
                rests.extend(with_progress(runs, "machines at rest", |done| {
                    rest::run(machine, &law, *follows, &poses[..count], &store, done)
                })?);
            }
        }
    }
    print(text(&rests))?;
    rest::judge(&rests, &mut verdict);
    store.report_unused();
    write(args.csv.as_deref(), |file| {
        let joints = (1..=6)
            .map(|k| format!("zeta {k} [rad]"))
            .collect::<Vec<_>>();
        writeln!(
            file,
            "world,follows,law,payload [kg],{},swing,acted,rests",
            joints.join(",")
        )?;
        for Rest {
            world,
            follows,
            law,
            pose,
            payload,
            run,
        } in &rests
        {
            let world = world.name();
            let follows = format!("{follows:?}").to_lowercase();
            let pose = pose.map(|angle| angle.to_string()).join(",");
            let (swing, acted, rests) = (run.swing, run.acted, run.rests());
            writeln!(
                file,
                "{world},{follows},{law},{payload},{pose},{swing},{acted},{rests}"
            )?;
        }
        Ok(())
    })?;
    let mut found = found.unwrap_or_default();
    found["machines"] = serde_json::to_value(&rests)?;
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}

/// A row for each world, reference and law.
fn text(rests: &[Rest]) -> String {
    let mut text = format!(
        "{:<8}{:<9}{:<22}{:>8}{:>8}{:>12}{:>12}{:>16}\n",
        "world", "follows", "law", "runs", "rest", "swing", "supervised", "worst swing, %"
    );
    let same = |a: &Rest, b: &Rest| (a.world, a.follows, &a.law) == (b.world, b.follows, &b.law);
    for rows in rests.chunk_by(same) {
        let Some(first) = rows.first() else { continue };
        let count = |is: &dyn Fn(&&Rest) -> bool| rows.iter().filter(is).count();
        let swing = |rest: &&Rest| rest.run.swing > crate::measures::swinging::SWINGS;
        let _ = writeln!(
            text,
            "{:<8}{:<9}{:<22}{:>8}{:>8}{:>12}{:>12}{:>16.2}",
            first.world.name(),
            format!("{:?}", first.follows).to_lowercase(),
            first.law,
            rows.len(),
            count(&|rest| rest.run.rests()),
            count(&swing),
            count(&|rest| rest.run.acted),
            100.0 * rows.iter().map(|rest| rest.run.swing).fold(0.0, f64::max)
        );
    }
    text + "5 s after a push of 300 N for 0.2 s, in random poses that the machine can hold; swing: a rod's force, root mean square over a second, above 1 % of its rated force\n"
}
