//! Subcommand `weighing`: payloads of all sizes and places, with and without weighing of the hook.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};

use crate::analyses::draws::Counts;
use crate::analyses::weighing::{self, PAYLOADS, Weighed};
use crate::print::output::{conditions, finish, with_progress, write};
use crate::runs::grid::Spread;
use crate::runs::run_store::RunStore;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{Law, MODES, SHIPPED};
use crate::worlds::World;

#[derive(Args)]
pub struct WeighingArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Controller
    #[arg(long, value_parser = MODES, default_value = SHIPPED)]
    mode: String,
    /// Payloads, kg, repeatable [default: 0, 20, 50, 100, 200, 300, 380]
    #[arg(long = "payload", value_name = "KG")]
    payloads: Vec<f64>,
    /// Centre of mass less the one that the controller knows, m, repeatable [default: none, 0.25 and
    /// 0.5 along each axis, and the corners of a cube]
    #[arg(long = "shift", value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    shifts: Vec<[f64; 3]>,
    /// Keep runs in this folder and reuse those that are there, to continue an interrupted command
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// Also write all payloads to this CSV file
    #[arg(long, value_name = "FILE", value_parser = output())]
    csv: Option<PathBuf>,
    /// Also write all payloads to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

fn place(text: &str) -> Result<[f64; 3]> {
    let numbers: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let place: Option<[f64; 3]> = numbers.try_into().ok();
    place.context("three numbers are needed, such as 0,-0.3,0")
}

/// Prints the errors of payloads with and without weighing.
pub fn weighing(args: &WeighingArgs) -> Result<Verdict> {
    let setup = args.machine.setup().world(World::Real).build()?;
    let (system, base, mut verdict) = setup.into_parts();
    ensure!(
        base.stop.is_none(),
        "--stop-time cannot be used here: the study sets the length of each run"
    );
    let mut found = conditions(&system, &base);
    let law = Law::new(&*args.mode, &args.mode);
    let payloads = match &args.payloads[..] {
        [] => &PAYLOADS,
        payloads => payloads,
    };
    let shifts = match &args.shifts[..] {
        [] => weighing::shifts(),
        shifts => shifts.into(),
    };
    let store = RunStore::new(args.store.as_deref())?;
    let count = (payloads.len() * shifts.len()) as u64;
    let weighed = with_progress(count, "payloads", |done| {
        weighing::run((&system, &base), &law, payloads, &shifts, &store, done)
    })?;
    print(text(payloads, &weighed))?;
    weighing::judge(&weighed, &mut verdict);
    store.report_unused();
    write(args.csv.as_deref(), |file| {
        writeln!(
            file,
            "payload [kg],x [m],y [m],z [m],weighed,error [m],not weighed,error [m]"
        )?;
        for w in &weighed {
            let [x, y, z] = w.shift;
            write!(file, "{},{x},{y},{z}", w.payload)?;
            for run in [&w.with, &w.without] {
                let rmse = run.rmse.map_or(String::new(), |rmse| rmse.to_string());
                write!(file, ",{},{rmse}", format!("{:?}", run.fate).to_lowercase())?;
            }
            writeln!(file)?;
        }
        Ok(())
    })?;
    found["payloads"] = serde_json::to_value(&weighed)?;
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}

/// A row for each payload: fates and errors over all places of its centre of mass.
fn text(payloads: &[f64], weighed: &[Weighed]) -> String {
    let mut text = format!(
        "{:>11}{:>8}{:>26}{:>26}{:>26}\n{:>11}{:>8}{:>26}{:>26}{:>26}\n",
        "payload, kg",
        "places",
        "kept, stopped, lost",
        "error, mm, weighed",
        "largest ratio of errors",
        "",
        "",
        "weighed / not",
        "median, worst / not",
        "(shift of the centre, m)"
    );
    for payload in payloads {
        let rows = || weighed.iter().filter(|w| w.payload == *payload);
        let [with, without] = [true, false].map(|is_weighed| {
            let run = move |w: &'_ Weighed| {
                if is_weighed {
                    w.with.clone()
                } else {
                    w.without.clone()
                }
            };
            let runs: Vec<_> = rows().map(run).collect();
            let Counts {
                kept,
                stopped,
                lost,
                ..
            } = Counts::from_runs(&runs);
            let error = Spread::from_values(runs.iter().filter_map(|run| run.rmse));
            let errors = format!("{:.2}, {:.2}", 1e3 * error.median, 1e3 * error.worst);
            (format!("{kept}, {stopped}, {lost}"), errors)
        });
        let largest = rows().filter_map(|w| Some((w.ratio()?, w.shift)));
        let largest = largest.max_by(|a, b| a.0.total_cmp(&b.0));
        let largest = largest.map_or("-".into(), |(ratio, [x, y, z])| {
            format!("{ratio:.2} ({x}, {y}, {z})")
        });
        let pair = |a: String, b: String| format!("{a} / {b}");
        let (fates, errors) = (pair(with.0, without.0), pair(with.1, without.1));
        let places = rows().count();
        let _ = writeln!(
            text,
            "{payload:>11}{places:>8}{fates:>26}{errors:>26}{largest:>26}"
        );
    }
    text + "centre of mass less the one that the controller knows; errors are those of the kept runs' tips as the controller knows them, triangular path\n"
}
