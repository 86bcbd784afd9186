//! Subcommand `tournament`: tunes all control laws by the same method, then compares them on
//! machines that they were not tuned on.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};

use crate::analyses::identification::model::Condition;
use crate::analyses::identification::run::{Commissioning, Identified};
use crate::analyses::tournament::{
    self, Asked, CONTESTANTS, Contestant, Model, Row, Sample, TUNING_PATHS, Tournament, Tuned,
};
use crate::print::output::{conditions, with_progress, write_json};
use crate::runs::ended_run::EndedRun;
use crate::runs::grid::{ALL_TRAJECTORIES, Case, Spread};
use crate::runs::run_store::RunStore;
use crate::setup::run_setup::MachineArgs;
use crate::worlds::{World, cases};

/// Law with which the errors of the others are compared.
const REFERENCE: &str = "adaptive_integral";
/// What the columns of a table mean.
const LEGEND: &str = "known error over the runs that were kept; force: runs in which a rod had more than 1.2 x its rated force; ratio: error over that of \
     adaptive_integral, or of the first law without it, geometric mean over the runs that both kept";
/// Mean simulated time of a run that is kept, s, to estimate the duration of the command.
const RUN: f64 = 18.0;

#[derive(Args)]
pub struct TournamentArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Law, repeatable [default: all]
    #[arg(long = "law", value_name = "MODE", value_parser = CONTESTANTS.map(|c| c.name))]
    laws: Vec<String>,
    /// Number of candidates for the gains of each law
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u64).range(1..))]
    budget: u64,
    /// Number of machines for tuning, from seed 101 on
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    tuning_seeds: u64,
    /// Number of machines on which the gains that were the best one after the other are tried, from seed 201 on;
    /// those that fail least are taken
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..))]
    trial_seeds: u64,
    /// Number of machines for the report, from seed 1 on
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..=100))]
    seeds: u64,
    /// Drives of the wrist without friction, play and lag, instead of those that are drawn
    #[arg(long)]
    ideal_wrist: bool,
    /// Then tune so many of the best laws that a controller can have with twice the budget, and compare them
    /// again: their order should not change
    #[arg(long, default_value_t = 0, value_name = "NUMBER")]
    again: usize,
    /// Path of the report, repeatable [default: all]
    #[arg(long = "path", value_name = "PATH", value_parser = ALL_TRAJECTORIES)]
    paths: Vec<String>,
    /// Keep runs in this folder and reuse those that are there, to continue an interrupted command
    #[arg(long, value_name = "DIR", default_value = "tournament")]
    store: PathBuf,
    /// Also write gains and runs to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// Tuned laws with their runs in the report.
type Reports = Vec<(Tuned, Vec<EndedRun>)>;

/// A tournament, with the machines and paths of its report.
struct Contest<'a> {
    tournament: Tournament<'a>,
    reporting: &'a [Case],
    paths: Vec<&'static str>,
}

/// Tunes every law, then runs the report and prints it.
pub fn tournament(args: &TournamentArgs) -> Result<Verdict> {
    let world = World::StrictRigid;
    let setup = args.machine.setup().world(world).build()?;
    let (system, base, verdict) = setup.into_parts();
    let mut found = conditions(&system, &base);
    let drawn = |seeds| {
        let drawn = cases(world, &system, seeds, 1.0)?;
        if args.ideal_wrist {
            return drawn.without(&system, "hdrm.wrist");
        }
        Ok(drawn)
    };
    let tuning = drawn(101..101 + args.tuning_seeds)?;
    let trial = drawn(201..201 + args.trial_seeds)?;
    let reporting = drawn(1..1 + args.seeds)?;
    let store = &RunStore::new(Some(&args.store))?;
    let mut contest = Contest {
        tournament: Tournament {
            system: &system,
            base: &base,
            store,
            identified: Identified::new(),
            sample: Sample::draw(&system, &base)?,
            tuning: &tuning.list,
            trial: &trial.list,
        },
        reporting: &reporting.list,
        paths: ALL_TRAJECTORIES.to_vec(),
    };
    (contest.paths).retain(|path| args.paths.is_empty() || args.paths.iter().any(|p| p == path));
    let chosen = |name: &str| args.laws.is_empty() || args.laws.iter().any(|law| law == name);
    let laws: Vec<_> = CONTESTANTS.iter().filter(|c| chosen(c.name)).collect();
    eprintln!("{}", contest.estimate(&laws, args)?);
    if laws.iter().any(|law| law.model == Model::Identified) {
        let cases = [&tuning.list[..], &trial.list, &reporting.list].concat();
        let commissioning = Commissioning::new(&system, &base, &args.store)?;
        let identified = with_progress(cases.len() as u64, "machines identified", |done| {
            commissioning.identify((&system, &base), &cases, store, done)
        })?;
        found["excitation"] = serde_json::to_value(commissioning.condition())?;
        eprintln!("{}", identification(&commissioning, &identified));
        contest.tournament.identified = identified;
    }
    let reports = contest.compete(&laws, args.budget)?;
    let rows = report_rows(&reports, 0, 1)?;
    let mut tables = table("law", &rows);
    for (k, path) in contest.paths.iter().enumerate() {
        let rows = report_rows(&reports, k, contest.paths.len())?;
        tables += &table(path, &rows);
        found["paths"][path] = serde_json::to_value(rows)?;
    }
    print(format!("{tables}{LEGEND}\n\n{}", gains(&reports)))?;
    let law = |row: &Row| laws.iter().copied().find(|law| law.name == row.law);
    let real = rows
        .iter()
        .filter_map(law)
        .filter(|law| law.model != Model::True);
    let best: Vec<_> = real.take(args.again).collect();
    if !best.is_empty() {
        let again = contest.compete(&best, 2 * args.budget)?;
        let rows = report_rows(&again, 0, 1)?;
        let names = best.iter().map(|law| law.name);
        let order = if rows.iter().map(|row| &*row.law).eq(names) {
            "the same order"
        } else {
            "ANOTHER ORDER"
        };
        print(format!(
            "\nwith twice the budget: {order}\n{}\n{}",
            table("law", &rows),
            gains(&again)
        ))?;
        found["again"] = serde_json::to_value(&rows)?;
    }
    found["rows"] = serde_json::to_value(&rows)?;
    let (tuned, ended): (Vec<_>, Vec<_>) = reports.into_iter().unzip();
    found["tuned"] = serde_json::to_value(tuned)?;
    found["runs"] = serde_json::to_value(ended)?;
    write_json(args.json.as_deref(), &found)?;
    store.report_unused();
    Ok(verdict)
}

impl Contest<'_> {
    /// Text on how long the tournament takes at most, from a run that is made for it.
    fn estimate(&self, laws: &[&Contestant], args: &TournamentArgs) -> Result<String> {
        let contest = &self.tournament;
        let begun = Instant::now();
        let simulated = contest.sample_run(laws[0], &contest.tuning[0])?;
        let each = begun.elapsed().as_secs_f64() / simulated * RUN;
        let count = |laws: usize, budget: u64| {
            let tuned = tries(laws, budget) * contest.tuning.len() as u64;
            let machines = tuned + (laws * contest.trial.len()) as u64;
            machines * TUNING_PATHS.len() as u64 + self.report_runs(laws)
        };
        let again = args.again.min(laws.len());
        let all = count(laws.len(), args.budget) + count(again, 2 * args.budget);
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let hours = each * all as f64 / cores as f64 / 3600.0;
        Ok(format!(
            "{each:.1} s a run, {all} runs on {cores} cores: {hours:.1} hours, and some minutes for what gains that win must do besides; lost runs end early, kept ones are not repeated"
        ))
    }

    /// Tunes `laws` with `budget` candidates each and makes the runs of their report.
    fn compete(&self, laws: &[&Contestant], budget: u64) -> Result<Reports> {
        let results = with_progress(tries(laws.len(), budget), "candidates", |done| {
            self.tournament.tune(laws, budget, done)
        })?;
        with_progress(self.report_runs(laws.len()), "runs", |done| {
            let report = |(law, tuned): (&&Contestant, Tuned)| {
                let contest = &self.tournament;
                let ended =
                    contest.report((law, &tuned.settings), self.reporting, &self.paths, done)?;
                Ok((tuned, ended))
            };
            laws.iter().zip(results).map(report).collect()
        })
    }

    /// Number of runs in the report of so many laws.
    fn report_runs(&self, laws: usize) -> u64 {
        (laws * self.reporting.len() * self.paths.len()) as u64
    }
}

/// Rows of every `step`-th run from `first` on.
fn report_rows<'a>(reports: &'a Reports, first: usize, step: usize) -> Result<Vec<Row>> {
    let of = |(tuned, runs): &'a (Tuned, Vec<EndedRun>)| {
        let runs = runs.iter().skip(first).step_by(step);
        (&*tuned.law, runs.collect())
    };
    tournament::rows(&Vec::from_iter(reports.iter().map(of)), REFERENCE)
}

/// Candidates of `laws` with `budget` each; each law twice tries the best gains of all others.
fn tries(laws: usize, budget: u64) -> u64 {
    let laws = laws as u64;
    laws * (budget + 2 * laws.saturating_sub(1))
}

/// Text on the identified models.
fn identification(commissioning: &Commissioning, identified: &Identified) -> String {
    let Condition { base, number } = commissioning.condition();
    let found: Vec<_> = identified.values().flatten().collect();
    let pair = |k: usize| {
        let [nominal, identified] = [0, 1].map(|model| {
            let forces = found.iter().map(|found| found.forces[model][k]);
            Spread::from_values(forces).median
        });
        format!("{nominal:.0} -> {identified:.0}")
    };
    let mut text = format!(
        "{} of {} machines identified; base regressor: {base} columns, condition {number:.0}; forces left by the nominal -> by the identified \
         model, RMS, median: rods {} N, wrist {} N.m",
        found.len(),
        identified.len(),
        [0, 1, 2].map(pair).join(", "),
        [3, 4, 5].map(pair).join(", ")
    );
    for (case, why) in identified {
        if let Err(why) = why {
            let _ = write!(text, "\n{case} keeps the nominal model: {why}");
        }
    }
    text
}

/// A table of the report; `title` stands over the laws.
fn table(title: &str, rows: &[Row]) -> String {
    let mut text = format!(
        "{title:<28}{:>7}{:>9}{:>7}{:>12}{:>11}{:>11}  ratio (95 %)\n",
        "lost", "stopped", "kept", "median, mm", "worst, mm", "force"
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
            "{:<28}{:>7}{:>9}{:>7}{:>12}{:>11}{:>11}  {ratio}",
            row.law,
            row.counts.lost,
            row.counts.stopped,
            row.counts.kept,
            mm(row.error.median),
            mm(row.error.worst),
            row.counts.forced
        );
    }
    text + "\n"
}

/// A line on the tuned gains of each law.
fn gains(reports: &Reports) -> String {
    let mut text = String::new();
    for (t, _) in reports {
        let cost = match t.cost {
            Some(cost) => format!("cost {:.3} mm", 1e3 * cost),
            None => "lost with every candidate, so as shipped".into(),
        };
        let gain = |(name, value): &(_, _)| format!("{name} {value:.4}");
        let gains = t.gains.iter().map(gain);
        let asked = t.asked.iter().copied().map(Asked::name);
        text += &format!(
            "{}: {cost}, {} of {} candidates kept every run, {} were the best one after the other, {} of them tried, with {} failures; {}; asked for besides: {}\n",
            t.law,
            t.kept,
            t.tried,
            t.bests,
            t.trials,
            t.failures,
            Vec::from_iter(gains).join(", "),
            Vec::from_iter(asked).join(", ")
        );
    }
    text
}
