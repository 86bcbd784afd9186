//! Subcommand `sizing`, also for the report's figures: loads of actuators compared with ratings.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};

use crate::analyses::sizing::{self, Sizing};
use crate::print::output::{conditions, finish, write};
use crate::print::sizing::{text, write_csv};
use crate::setup::run_setup::MachineArgs;

#[derive(Args)]
pub struct SizingArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Change of the payload from which the sensitivity is computed, kg; 0: no sensitivity
    #[arg(long, default_value_t = 10.0, value_name = "KG")]
    payload_step: f64,
    /// Draw torque over motor speed under both envelopes, as PNG and SVG into this directory
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Also write the numbers to this CSV file
    #[arg(long, value_name = "FILE", value_parser = output())]
    csv: Option<PathBuf>,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// Prints the loads of motors and actuators; also returns them for each case, for figures.
pub fn sizing(args: &SizingArgs) -> Result<(Verdict, Vec<(String, Sizing)>)> {
    let setup = args.machine.setup().build()?;
    let mut found = conditions(&setup.system, &setup.base);
    let (done, verdict) = sizing::cases(setup, args.payload_step, |case, sizing| {
        print(text(sizing, &format!("{case} trajectory")) + "\n")
    })?;
    write(args.csv.as_deref(), |to| write_csv(&done, to))?;
    for (case, sizing) in &done {
        found["sizing"][case] = serde_json::to_value(sizing)?;
    }
    Ok((finish(found, verdict, args.json.as_deref(), true)?, done))
}
