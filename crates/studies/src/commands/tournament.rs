//! Subcommand `tournament`: laws tuned alike and compared on machines that they were not tuned on.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use cosim::cli::{bar, print};
use cosim::verdict::Verdict;

use crate::bench::MachineArgs;
use crate::grid::ALL_TRAJECTORIES;
use crate::print::files::{conditions, write_json};
use crate::studies::tournament::{self, Arena, CONTESTANTS, Row, TUNING_PATHS, Tuned};
use crate::trial::Store;
use crate::worlds::{World, cases};

/// Law to which the errors of the others are compared.
const REFERENCE: &str = "adaptive_integral";
/// Mean length of a run that is kept, s.
const RUN: f64 = 18.0;

#[derive(Args)]
pub struct TournamentArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Laws, repeatable [default: all]
    #[arg(long = "law", value_name = "MODE", value_parser = CONTESTANTS.map(|c| c.mode))]
    laws: Vec<String>,
    /// Candidates for the gains of each law
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u64).range(1..))]
    budget: u64,
    /// Machines to tune on, from seed 101 on
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    tuning_seeds: u64,
    /// Machines to report on, from seed 1 on
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..=100))]
    seeds: u64,
    /// Keep each run in this folder, and take those that are there: an interrupted command goes on
    #[arg(long, value_name = "DIR", default_value = "tournament")]
    store: PathBuf,
    /// Also write gains and runs to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Tune every law, then report.
pub fn tournament(args: &TournamentArgs) -> Result<Verdict> {
    let world = World::StrictRigid;
    let bench = args.machine.bench().world(world).build()?;
    let (system, base, verdict) = bench.into_parts();
    let mut found = conditions(&system, &base);
    let tuning = cases(world, &system, 101..101 + args.tuning_seeds)?;
    let reporting = cases(world, &system, 1..1 + args.seeds)?;
    let store = &Store::new(Some(&args.store), &system)?;
    let arena = Arena {
        system: &system,
        base: &base,
        store,
    };
    let chosen = |mode: &str| args.laws.is_empty() || args.laws.iter().any(|law| law == mode);
    let laws: Vec<_> = CONTESTANTS.iter().filter(|c| chosen(c.mode)).collect();
    let tries = laws.len() as u64 * args.budget;
    let runs = (laws.len() * reporting.list.len() * ALL_TRAJECTORIES.len()) as u64;
    let begun = Instant::now();
    let simulated = arena.first(laws[0], &tuning.list)?;
    let each = begun.elapsed().as_secs_f64() / simulated * RUN;
    let all = tries * args.tuning_seeds * TUNING_PATHS.len() as u64 + runs;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let hours = each * all as f64 / cores as f64 / 3600.0;
    eprintln!(
        "{each:.1} s a run, {all} runs on {cores} cores: at most {hours:.1} hours; lost runs end early, kept ones are not repeated"
    );
    let progress = bar(tries, "candidates", false);
    let mut results = Vec::new();
    for law in &laws {
        let done = || progress.inc(1);
        results.push(arena.tune(law, &tuning.list, args.budget, done)?);
    }
    progress.finish_and_clear();
    let progress = bar(runs, "runs", false);
    let mut reports = Vec::new();
    for tuned in results {
        let trials = arena.report(&tuned, &reporting.list, &ALL_TRAJECTORIES, || {
            progress.inc(1);
        })?;
        reports.push((tuned, trials));
    }
    progress.finish_and_clear();
    let rows = tournament::rows(&reports, REFERENCE)?;
    print(text(&rows) + "\n" + &gains(reports.iter().map(|(tuned, _)| tuned)))?;
    found["rows"] = serde_json::to_value(&rows)?;
    let (tuned, trials): (Vec<_>, Vec<_>) = reports.into_iter().unzip();
    found["tuned"] = serde_json::to_value(tuned)?;
    found["runs"] = serde_json::to_value(trials)?;
    write_json(args.json.as_deref(), &found)?;
    Ok(verdict)
}

/// Failures first.
fn text(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<22}{:>7}{:>9}{:>7}{:>12}{:>11}{:>11}  error / that of {REFERENCE} (95 %)\n",
        "law", "lost", "stopped", "kept", "median, mm", "worst, mm", "force"
    );
    for row in rows {
        let mm = |v: f64| match v.is_finite() {
            true => format!("{:.3}", 1e3 * v),
            false => "-".into(),
        };
        let ratio = row.ratio.map_or("-".into(), |[mean, low, high]| {
            format!("{mean:.2} ({low:.2} to {high:.2})")
        });
        let _ = writeln!(
            text,
            "{:<22}{:>7}{:>9}{:>7}{:>12}{:>11}{:>11}  {ratio}",
            row.law,
            row.counts.lost,
            row.counts.stopped,
            row.counts.kept,
            mm(row.error.median),
            mm(row.error.worst),
            format!("{} > 1.2", row.counts.forced)
        );
    }
    text + "known error over the runs that were kept; force: runs in which a rod had more than 1.2 x its rated force\n"
}

/// What tuning came to.
fn gains<'a>(tuned: impl Iterator<Item = &'a Tuned>) -> String {
    let mut text = String::new();
    for Tuned {
        law,
        gains,
        cost,
        kept,
        tried,
        ..
    } in tuned
    {
        let cost = cost.map_or("lost with every candidate, so as shipped".into(), |cost| {
            format!("cost {:.3} mm", 1e3 * cost)
        });
        let gains: Vec<_> = (gains.iter())
            .map(|(name, value)| format!("{name} {value:.4}"))
            .collect();
        let _ = writeln!(
            text,
            "{law}: {cost}, {kept} of {tried} candidates kept every run; {}",
            gains.join(", ")
        );
    }
    text
}
