//! Subcommand `path`: what is asked of path files before anything runs.

use std::path::PathBuf;

use crate::machines::path_margins::PathMargins;
use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use cosim::cli::print;

use crate::print::output::write_json;
use crate::setup::machine_choice::read;

#[derive(Subcommand)]
pub enum PathCommand {
    /// Whether the machine can do a path: least margins of reach, joints, strokes, speeds, forces,
    /// wrist and motors; fails where it cannot
    Check(CheckArgs),
    /// Duration and length of a path, and when the tip is at which waypoint
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
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Do it.
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

/// Print the margins, which may be drawn, and write them.
pub fn check(args: &CheckArgs) -> Result<PathMargins> {
    let margins = args.path.margins()?;
    print(margins.description() + &margins.table())?;
    write_json(args.json.as_deref(), &margins.json())?;
    Ok(margins)
}

/// Say whether the machine can do the path; an error where it cannot.
pub fn verdict(margins: &PathMargins) -> Result<()> {
    match margins.checked.refusal() {
        Some(refusal) => bail!("path `{}`: {refusal}", margins.name),
        None => print("the machine can do this path\n"),
    }
}
