//! Subcommand `margins`: how far each law is from instability.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use cosim::Verdict;
use cosim::cli::print;

use crate::analyses::margins::{self, CHANGES, Limit, Margin, PAYLOADS, PLACES};
use crate::print::output::{conditions, finish, with_progress, write};
use crate::runs::run_store::RunStore;
use crate::setup::run_setup::MachineArgs;
use crate::setup::start_values::{MODES, of_modes};
use crate::worlds::World;

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
    /// Keep each run in this folder, and take those that are there: an interrupted command goes on
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// Also write all margins to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also write all margins to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// How far each law is from instability.
pub fn margins(args: &MarginsArgs) -> Result<Verdict> {
    let setup = args.machine.setup().world(World::Real).build()?;
    let (system, base, mut verdict) = setup.into_parts();
    ensure!(
        base.stop.is_none(),
        "--stop-time: how long a run takes is part of the study"
    );
    let mut found = conditions(&system, &base);
    let usual = [
        "adaptive_integral",
        "adaptive",
        "modular_integral",
        "pd_gravity_integral",
    ];
    let modes: Vec<&str> = match &args.laws[..] {
        [] => usual.into(),
        laws => laws.iter().map(String::as_str).collect(),
    };
    let laws = of_modes(&modes);
    let mut places = PLACES.to_vec();
    places.retain(|(name, _)| args.places.is_empty() || args.places.iter().any(|p| p == name));
    let payloads = match &args.payloads[..] {
        [] => &PAYLOADS,
        payloads => payloads,
    };
    let store = RunStore::new(args.store.as_deref(), &system)?;
    let of_adaptive = laws.iter().filter(|law| law.name.starts_with("adaptive"));
    let count = (CHANGES.len() - 1) * laws.len() + of_adaptive.count();
    let count = (count * places.len() * payloads.len()) as u64;
    let margins = with_progress(count, "margins", |done| {
        margins::run((&system, &base), &laws, &places, payloads, &store, done)
    })?;
    print(text(&modes, &margins))?;
    margins::judge(&margins, &mut verdict);
    write(args.csv.as_deref(), |file| {
        writeln!(file, "law,place,payload [kg],change,stable,beyond,limit")?;
        for m in &margins {
            let what = m.change.name().replace(',', "");
            let beyond = m.beyond.map(|(beyond, _)| beyond.to_string());
            let limit = serde_json::to_value(m.beyond.map(|(_, limit)| limit))?;
            writeln!(
                file,
                "{},{},{},{what},{},{},{}",
                m.law,
                m.place,
                m.payload,
                m.stable,
                beyond.unwrap_or_default(),
                limit.as_str().unwrap_or_default()
            )?;
        }
        Ok(())
    })?;
    found["margins"] = serde_json::to_value(&margins)?;
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}

/// The least margin of each law and change, with the place and the payload that have it; one that a
/// rod's force ends earlier stands below it.
fn text<'a>(laws: &[&str], margins: &'a [Margin]) -> String {
    let [stability, force] =
        [Limit::Stability, Limit::Force].map(|limit| margins::least(margins, limit));
    let mut text = format!("{:<22}", "stable up to");
    for law in laws {
        let _ = write!(text, "{law:>28}");
    }
    text += "\n";
    for (change, what, ..) in CHANGES {
        let of = |least: &[&'a Margin], law: &str| {
            let mut least = least.iter().copied();
            least.find(|m| m.law == law && m.change == change)
        };
        let _ = write!(text, "{what:<22}");
        let mut of_force = String::new();
        for law in laws {
            let loops = of(&stability, law);
            let rods = of(&force, law).filter(|rods| {
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
