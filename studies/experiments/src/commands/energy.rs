//! Subcommand `energy`: energy balances of the actuators and of the component that feeds them.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};

use crate::measures::energy;
use crate::print::energy::{balance_json, supply_text, text, write_csv};
use crate::print::output::{conditions, finish, write};
use crate::setup::run_setup::MachineArgs;

#[derive(Args)]
pub struct EnergyArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Also write the actuators' energies to this CSV file
    #[arg(long, value_name = "FILE", value_parser = output())]
    csv: Option<PathBuf>,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// Prints the energy balances on both trajectories, or on the one that is set.
pub fn energy(args: &EnergyArgs) -> Result<Verdict> {
    let (system, base, mut verdict) = args.machine.setup().build()?.into_parts();
    let mut done = Vec::new();
    for (case, experiment) in energy::trajectory_cases(&system, &base)? {
        let energies = energy::run(&system, &experiment)?;
        print(text(&format!("{case} trajectory"), &energies.balances) + "\n")?;
        verdict.extend(energies.verdict.clone().prefixed(&case));
        if let Some(supply) = &energies.supply {
            print(supply_text(supply) + "\n")?;
            verdict.extend(supply.verdict().prefixed(&case));
        }
        done.push((case, energies));
    }
    write(args.csv.as_deref(), |to| write_csv(&done, to))?;
    let mut found = conditions(&system, &base);
    for (case, energies) in &done {
        found["energy"][case] = energies.balances.iter().map(balance_json).collect();
        found["supply"][case] = serde_json::to_value(&energies.supply)?;
    }
    finish(found, verdict, args.json.as_deref(), true)
}
