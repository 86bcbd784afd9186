//! Subcommand `margins`: how far each control law is from instability, in delay, gain and more.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};
use cosim::io::cells::cell;

use crate::analyses::margins::{self, CHANGES, Limit, Margin, PAYLOADS, PLACES};
use crate::print::output::{conditions, finish, with_progress, write};
use crate::runs::run_store::RunStore;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{MODES, SHIPPED, laws_of_modes};
use crate::worlds::World;

/// Laws that are compared by default.
const DEFAULT_LAWS: [&str; 4] = [
    SHIPPED,
    "adaptive",
    "modular_integral",
    "pd_gravity_integral",
];

#[derive(Args)]
pub struct MarginsArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Laws, repeatable [default: adaptive_integral, adaptive, modular_integral,
    /// pd_gravity_integral]
    #[arg(long = "law", value_name = "MODE", value_parser = MODES)]
    laws: Vec<String>,
    /// Poses to rest in and paths to follow, repeatable [default: all]
    #[arg(long = "place", value_name = "NAME", value_parser = PLACES.map(|(name, _)| name))]
    places: Vec<String>,
    /// Payloads, kg, repeatable [default: 1, 300]
    #[arg(long = "payload", value_name = "KG")]
    payloads: Vec<f64>,
    /// Keep runs in this folder and reuse those that are there, to continue an interrupted command
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// Also write all margins to this CSV file
    #[arg(long, value_name = "FILE", value_parser = output())]
    csv: Option<PathBuf>,
    /// Also write all margins to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// Prints the smallest margin of each law and change.
pub fn margins(args: &MarginsArgs) -> Result<Verdict> {
    let setup = args.machine.setup().world(World::Real).build()?;
    let (system, base, mut verdict) = setup.into_parts();
    ensure!(
        base.stop.is_none(),
        "--stop-time cannot be used here: the study sets the length of each run"
    );
    let mut found = conditions(&system, &base);
    let modes: Vec<&str> = match &args.laws[..] {
        [] => DEFAULT_LAWS.into(),
        laws => laws.iter().map(String::as_str).collect(),
    };
    let laws = laws_of_modes(&modes);
    let mut places = PLACES.to_vec();
    places.retain(|(name, _)| args.places.is_empty() || args.places.iter().any(|p| p == name));
    let payloads = match &args.payloads[..] {
        [] => &PAYLOADS,
        payloads => payloads,
    };
    let store = RunStore::new(args.store.as_deref())?;
    let adaptive = laws.iter().filter(|law| law.name.starts_with("adaptive"));
    let count = (CHANGES.len() - 1) * laws.len() + adaptive.count();
    let count = (count * places.len() * payloads.len()) as u64;
    let margins = with_progress(count, "margins", |done| {
        margins::run((&system, &base), &laws, &places, payloads, &store, done)
    })?;
    print(text(&modes, &margins))?;
    margins::judge(&margins, &mut verdict);
    store.report_unused();
    write(args.csv.as_deref(), |file| {
        writeln!(file, "law,place,payload [kg],change,stable,beyond,limit")?;
        for m in &margins {
            let what = cell(m.change.name());
            let beyond = m.beyond.map(|(beyond, _)| beyond.to_string());
            let limit = serde_json::to_value(m.beyond.map(|(_, limit)| limit))?;
            let ends = [beyond.as_deref(), limit.as_str()].map(Option::unwrap_or_default);
            let (law, place, payload, stable) = (&m.law, &m.place, m.payload, m.stable);
            let ends = ends.join(",");
            writeln!(file, "{law},{place},{payload},{what},{stable},{ends}")?;
        }
        Ok(())
    })?;
    found["margins"] = serde_json::to_value(&margins)?;
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}

/// The smallest margin of each law and change, with its place and payload; below it the smallest
/// one at which a rod's force exceeds its limit, if that is smaller.
fn text<'a>(laws: &[&str], margins: &'a [Margin]) -> String {
    let [stability, force] =
        [Limit::Stability, Limit::Force].map(|limit| margins::least(margins, limit));
    let mut text = format!("{:<22}", "stable up to");
    for law in laws {
        let _ = write!(text, "{law:>28}");
    }
    text += "\n";
    for (change, what, ..) in CHANGES {
        let find = |least: &[&'a Margin], law: &str| {
            let mut least = least.iter().copied();
            least.find(|m| m.law == law && m.change == change)
        };
        let _ = write!(text, "{what:<22}");
        let mut of_force = String::new();
        for law in laws {
            let loops = find(&stability, law);
            let rods = find(&force, law).filter(|rods| {
                rods.beyond.is_some() && loops.is_none_or(|loops| rods.stable < loops.stable)
            });
            let cell = |m: &Margin, more: &str| {
                format!("{:.2}{more} ({}, {} kg)", m.stable, m.place, m.payload)
            };
            let of_loops = loops.map_or("-".into(), |m| {
                cell(m, if m.beyond.is_some() { "" } else { "+" })
            });
            let _ = write!(text, "{of_loops:>28}");
            let of_rods = rods.map_or(String::new(), |m| cell(m, ""));
            let _ = write!(of_force, "{of_rods:>28}");
        }
        text += "\n";
        if !of_force.trim().is_empty() {
            let _ = writeln!(text, "{:<22}{of_force}", "  by the rods' force");
        }
    }
    text + "least over places and payloads (where); +: the largest that is tried; 0: unstable without any change; runs from rest and on paths, by bisection\n"
}
