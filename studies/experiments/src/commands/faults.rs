//! Subcommand `faults`: single faults of sensors, wires and drives, one run each.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};
use cosim::io::cells::cell;

use crate::analyses::faults::grid::{self, AT_REST, Instant, PATHS, PAYLOADS, SHARES};
use crate::analyses::faults::{self, FaultResult};
use crate::print::output::{conditions, finish, with_progress, write};
use crate::runs::ended_run::Fate;
use crate::runs::run_store::RunStore;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{Law, MODES, SHIPPED};
use crate::worlds::World;

#[derive(Args)]
pub struct FaultsArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Only faults whose names contain this text, such as `sensors.zeta`, `zeta[2] freeze` or
    /// `bias`; repeatable
    #[arg(long, value_name = "TEXT")]
    only: Vec<String>,
    /// Paths, repeatable; rates and rest have none [default: all but rest]
    #[arg(long = "path", value_name = "NAME", value_parser = PATHS)]
    paths: Vec<String>,
    /// Payloads, kg, repeatable [default: 0, 300]
    #[arg(long = "payload", value_name = "KG")]
    payloads: Vec<f64>,
    /// Size of biases, losses and drops; less than 1: only these, reported and not judged
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    size: f64,
    /// Only so many runs, drawn from all
    #[arg(long, value_name = "NUMBER")]
    sample: Option<usize>,
    /// Seed of the sample
    #[arg(long, default_value_t = 1, requires = "sample")]
    seed: u64,
    /// Controller
    #[arg(long, value_parser = MODES, default_value = SHIPPED)]
    mode: String,
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

/// Counts the faults after which the machine keeps its path, is stopped, or is lost.
pub fn faults(args: &FaultsArgs) -> Result<Verdict> {
    let size = args.size;
    ensure!(
        size > 0.0 && size <= 1.0,
        "--size {size}: it must be greater than 0 and at most 1"
    );
    let setup = args.machine.setup().world(World::Real).build()?;
    let (system, base, mut verdict) = setup.into_parts();
    ensure!(
        base.stop.is_none(),
        "--stop-time cannot be used here: the study sets the length of each run"
    );
    let mut found = conditions(&system, &base);
    let mut all = grid::faults(&system, &base, size)?;
    let is_asked = |name: &str| args.only.is_empty() || args.only.iter().any(|o| name.contains(o));
    all.retain(|fault| is_asked(&fault.to_string()));
    ensure!(
        !all.is_empty(),
        "--only {}: no fault has such a name; names are like `sensors.zeta[2] freeze`",
        args.only.join(", ")
    );
    let mut paths = PATHS.to_vec();
    paths.retain(|path| match &args.paths[..] {
        [] => *path != AT_REST,
        asked => asked.iter().any(|p| p == path),
    });
    let payloads = match &args.payloads[..] {
        [] => &PAYLOADS,
        payloads => payloads,
    };
    let mut cases = Vec::new();
    for path in paths {
        for payload in payloads.iter().copied() {
            for share in SHARES {
                let instant = Instant {
                    path,
                    payload,
                    share,
                };
                cases.extend(all.iter().map(|fault| (instant, fault.clone())));
            }
        }
    }
    let (whole, count) = (cases.len(), args.sample.unwrap_or(cases.len()));
    let cases = grid::sample(cases, count, args.seed);
    let store = RunStore::new(args.store.as_deref())?;
    let law = Law::new(&*args.mode, &args.mode);
    let machine = (&system, &base);
    let results = with_progress(cases.len() as u64, "faults", |done| {
        faults::run(machine, &law, &cases, &store, done)
    })?;
    print(text(&results, whole))?;
    faults::judge(&results, size == 1.0, &mut verdict);
    store.report_unused();
    write(args.csv.as_deref(), |file| {
        writeln!(
            file,
            "path,payload [kg],time [s],fault,fate,error [mm],distance [mm],oracle [mm],force,oracle force,braked after [s],cause,why"
        )?;
        for r in &results {
            let (run, [distance, force]) = (&r.run, r.run.oracle);
            let braked = run.braked.map_or(String::new(), |t| format!("{t:.3}"));
            writeln!(
                file,
                "{},{},{},{},{},{:.2},{:.2},{:.2},{:.3},{:.3},{braked},{},{}",
                r.path,
                r.payload,
                r.time,
                cell(&r.fault.to_string()),
                word(run.fate),
                1e3 * run.error,
                1e3 * run.distance,
                1e3 * distance,
                run.force,
                force,
                run.cause,
                cell(&run.why)
            )?;
        }
        Ok(())
    })?;
    found["faults"] = serde_json::to_value(&results)?;
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}

fn word(fate: Fate) -> &'static str {
    match fate {
        Fate::Kept => "kept",
        Fate::Stopped => "stopped",
        Fate::Lost => "lost",
    }
}

/// A row for the wires of each quantity: fates, and the farthest and the hardest stop; then each
/// lost run.
fn text(results: &[FaultResult], whole: usize) -> String {
    #[derive(Default)]
    struct Row {
        counts: [usize; 3],
        latest: f64,
        farthest: f64,
        hardest: f64,
    }
    let mut rows: BTreeMap<String, Row> = BTreeMap::new();
    for result in results {
        let wire = &result.fault.wire;
        let quantity = wire
            .split_once('[')
            .map_or(&**wire, |(quantity, _)| quantity);
        let quantity = (1..=3).fold(quantity.into(), |name: String, k| {
            name.replace(&format!("emla_{k}."), "emla_*.")
        });
        let run = &result.run;
        for name in [quantity, "~".into()] {
            let row = rows.entry(name).or_default();
            row.counts[run.fate as usize] += 1;
            if run.fate == Fate::Stopped {
                row.latest = row.latest.max(run.braked.unwrap_or_default());
                row.farthest = row.farthest.max(run.distance);
                row.hardest = row.hardest.max(run.force);
            }
        }
    }
    let mut text = format!(
        "{} of {whole} runs with a fault\n{:<28}{:>6}{:>9}{:>6}   worst stop: after, s   from the path, mm   force / rated\n",
        results.len(),
        "fault of",
        "kept",
        "stopped",
        "lost"
    );
    for (name, row) in &rows {
        let [kept, stopped, lost] = row.counts;
        let name = if name == "~" { "all" } else { name };
        let _ = write!(text, "{name:<28}{kept:>6}{stopped:>9}{lost:>6}");
        if stopped > 0 {
            let (farthest, hardest) = (1e3 * row.farthest, row.hardest);
            let _ = write!(text, "{:>23.3}{farthest:>20.1}{hardest:>16.2}", row.latest);
        }
        text += "\n";
    }
    for result in results.iter().filter(|r| r.run.fate == Fate::Lost) {
        let FaultResult {
            path,
            payload,
            time,
            fault,
            run,
        } = result;
        let _ = writeln!(
            text,
            "lost: {fault} at {time} s of {path}, {payload} kg: {}",
            run.why
        );
    }
    text
}
