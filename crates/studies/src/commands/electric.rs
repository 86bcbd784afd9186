//! Subcommands of the electrical side: `energy` and `sizing`.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::{energy, sizing};
use anyhow::{Context, Result};
use clap::Args;
use cosim::cli::print;
use cosim::verdict::Verdict;
use serde_json::Value;

use super::MachineArgs;
use super::evaluation::{conditions, create, write_json};

#[derive(Args)]
pub struct EnergyArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Also write the actuators' energies to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Args)]
pub struct SizingArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Change of the payload by which the sensitivity is found, kg; 0: it is not
    #[arg(long, default_value_t = 10.0, value_name = "KG")]
    payload_step: f64,
    /// Draw torque over motor speed under both envelopes, as PNG and SVG into this directory
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Also write the numbers to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Energy balances on both trajectories, or on the one that is set.
pub fn energy(args: &EnergyArgs) -> Result<Verdict> {
    let (system, base, mut verdict) = args.machine.load()?;
    let mut done = Vec::new();
    for (case, experiment) in energy::cases(&system, &base)? {
        let energies = energy::run(&system, &experiment)?;
        print(energy::text(&title(&case), &energies.balances) + "\n")?;
        verdict.extend(energies.verdict.clone().of(&case));
        if let Some(supply) = &energies.supply {
            print(supply.text() + "\n")?;
            verdict.extend(supply.verdict().of(&case));
        }
        done.push((case, energies));
    }
    write_csv(args.csv.as_deref(), |to| energy::write_csv(&done, to))?;
    let mut found = conditions(&system, &base);
    for (case, energies) in &done {
        let balances = energies.balances.iter().map(balance_json);
        found["energy"][case] = balances.collect::<Result<_>>()?;
        found["supply"][case] = serde_json::to_value(&energies.supply)?;
    }
    write_json(args.json.as_deref(), &found)?;
    print(&verdict)?;
    Ok(verdict)
}

/// Motors and actuators beside what they do; also returns what was found for each case, to be drawn.
pub fn sizing(args: &SizingArgs) -> Result<(Verdict, Vec<(String, sizing::Sizing)>)> {
    let (system, base, mut verdict) = args.machine.load()?;
    let mut done = Vec::new();
    for (case, experiment) in energy::cases(&system, &base)? {
        let found = sizing::run(&system, &experiment, args.payload_step)?;
        print(found.text(&title(&case)) + "\n")?;
        verdict.extend(found.verdict().of(&case));
        done.push((case, found));
    }
    write_csv(args.csv.as_deref(), |to| sizing::write_csv(&done, to))?;
    let mut found = conditions(&system, &base);
    for (case, sizing) in &done {
        found["sizing"][case] = serde_json::to_value(sizing)?;
    }
    write_json(args.json.as_deref(), &found)?;
    print(&verdict)?;
    Ok((verdict, done))
}

fn title(case: &str) -> String {
    format!("{case} trajectory")
}

fn balance_json(balance: &energy::Balance) -> Result<Value> {
    let mut value = serde_json::to_value(balance)?;
    value["efficiency"] = balance.efficiency().into();
    value["throughput"] = balance.throughput().into();
    value["residual"] = balance.residual().into();
    Ok(value)
}

fn write_csv(
    path: Option<&Path>,
    write: impl FnOnce(&mut std::io::BufWriter<std::fs::File>) -> std::io::Result<()>,
) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let mut file = create(path)?;
    write(&mut file)
        .and_then(|()| file.flush())
        .with_context(|| path.display().to_string())
}
