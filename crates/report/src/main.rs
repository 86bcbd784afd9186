//! The program that draws: the evaluation as a page ([`report`]), machines on a sheet
//! ([`machines`]), signals over time ([`plot`]), figures of sizing and of paths. `hdrm-fmu` starts
//! it, by the same words; numbers come from crate `studies`.
#![forbid(unsafe_code)]

mod commands;
mod machines;
mod margins_figure;
mod plot;
mod report;
mod sizing_figure;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use commands::{figures, machine, page};
use cosim::Verdict;
use studies::commands::path::CheckArgs;
use studies::commands::program::{self, Ending};
use studies::commands::sizing::SizingArgs;

/// Pictures of the coupled manipulator: report, drawings of machines, signals over time.
#[derive(Parser)]
#[command(name = "hdrm-fmu", bin_name = "hdrm-fmu", version, about, long_about = None)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write the evaluation as one HTML file with tables, plots and a 3-D animation
    Report(page::ReportArgs),
    /// Motors and actuators beside what they do: RMS and peaks, envelopes, temperatures over an
    /// hour, sensitivity to the payload
    Sizing(SizingArgs),
    /// Draw the signals of a CSV file over time, as PNG and SVG
    Plot(commands::plot::PlotArgs),
    /// What is done to machine files
    #[command(subcommand)]
    Machine(MachineCommand),
    /// Paths of the tip
    #[command(subcommand)]
    Path(PathCommand),
}

#[derive(Subcommand)]
enum MachineCommand {
    /// Draw a machine: side view with named points and dimensions, workspace, greatest payload over
    /// reach and height
    Draw(machine::DrawArgs),
    /// Write a machine's bodies and loops as JSON, from which a page draws it in motion
    Scene(machine::SceneArgs),
}

#[derive(Subcommand)]
enum PathCommand {
    /// Whether the machine can do a path: least margins of reach, joints, strokes, speeds, forces,
    /// wrist and motors; fails where it cannot
    Check(CheckArgs),
}

fn main() -> ExitCode {
    let command = Cli::parse().command;
    program::run(command.needs_python(), || command.run())
}

impl Command {
    /// Whether it runs the plant that bends, which is written in Python.
    fn needs_python(&self) -> bool {
        matches!(self, Self::Report(args) if args.bending)
    }

    fn run(&self) -> Ending {
        let done = |result: Result<()>| (false, result.map(|()| Verdict::default()));
        match self {
            Self::Report(args) => (args.machine.check(), page::report(args)),
            Self::Sizing(args) => (args.machine.check(), figures::sizing(args)),
            Self::Plot(args) => done(commands::plot::plot(args)),
            Self::Machine(MachineCommand::Draw(args)) => done(machine::draw(args)),
            Self::Machine(MachineCommand::Scene(args)) => done(machine::scene(args)),
            Self::Path(PathCommand::Check(args)) => done(figures::path(args)),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    /// Arguments that are defined twice or contradict each other are found here, not by who runs
    /// the program.
    #[test]
    fn all_commands_are_well_defined() {
        super::Cli::command().debug_assert();
    }
}
