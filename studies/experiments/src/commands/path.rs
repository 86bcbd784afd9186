//! Subcommand `path`: describes a path file and checks whether a machine can follow it; the report
//! calls the check for its figures.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use cosim::cli::{output, print};

use crate::machines::path_margins::PathMargins;
use crate::print::output::write_json;
use crate::setup::machine_choice::read;

#[derive(Subcommand)]
pub enum PathCommand {
    /// Check whether a machine can follow a path: smallest margins of reach, joints, strokes,
    /// speeds, forces, wrist and motors; fails if it cannot
    Check(CheckArgs),
    /// Show duration and length of a path, and the times at its waypoints
    Show(PathArgs),
}

#[derive(Args)]
pub struct PathArgs {
    /// JSON or CSV file of waypoints or samples, or iso9283-cube, iso9283-rectangle,
    /// six-joints
    path: String,
    /// Machine file, or name of a shipped machine, whose limits and start pose count
    #[arg(long, value_name = "FILE|NAME", default_value = "reference")]
    machine: String,
}

#[derive(Args)]
pub struct CheckArgs {
    #[command(flatten)]
    path: PathArgs,
    /// Draw the margins along the path, as PNG and SVG into this directory
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// Runs a subcommand of `path`.
pub fn run(command: &PathCommand) -> Result<()> {
    match command {
        PathCommand::Check(args) => verdict(&check(args)?),
        PathCommand::Show(args) => {
            let margins = args.margins()?;
            print(margins.description() + &margins.stops())
        }
    }
}

impl PathArgs {
    fn margins(&self) -> Result<PathMargins> {
        PathMargins::new(&self.path, &read(&self.machine)?)
    }
}

/// Prints the margins and writes them as JSON; returns them for figures.
pub fn check(args: &CheckArgs) -> Result<PathMargins> {
    let margins = args.path.margins()?;
    print(margins.description() + &margins.table())?;
    write_json(args.json.as_deref(), &margins.json())?;
    Ok(margins)
}

/// Prints that the machine can follow the path; an error if it cannot.
pub fn verdict(margins: &PathMargins) -> Result<()> {
    match margins.checked.refusal() {
        Some(refusal) => bail!("path `{}`: {refusal}", margins.name),
        None => print("the machine can do this path\n"),
    }
}
