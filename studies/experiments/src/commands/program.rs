//! The command line of `hdrm-fmu`, and how a program gets from a command to its exit code: for the
//! programs `hdrm-fmu` and `hdrm-fmu-report`.
//!
//! Two other programs in the same folder execute some of the commands, so that `hdrm-fmu` builds in
//! a third of the time: `hdrm-fmu-report` draws, `hdrm-fmu-surrogate` trains networks. They get the
//! same arguments; the report shares this command line.

use std::env::{self, consts::EXE_SUFFIX};
use std::ffi::OsString;
use std::process::{self, ExitCode};

use anyhow::{Context, Result, ensure};
use clap::{Args, Parser, Subcommand};
use cosim::Verdict;
use cosim::cli::{claim_outputs, exit};
use cosim::run::interrupt;

use super::{
    compare, draws, endurance, energy, evaluate, faults, machine, margins, path, pictures, python,
    rest, run as run_command, sizing, stability, table, testbed, tournament, weighing,
};

/// Experiments on the coupled manipulator: three electromechanical actuators, rigid bodies and
/// controller, as FMUs.
#[derive(Parser)]
#[command(version, about, long_about = None)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Run one experiment and print tip error, power residuals and speed
    Run(run_command::RunArgs),
    /// Run one trajectory with the three controllers and print their tip RMSE and the paper's
    Compare(compare::CompareArgs),
    /// Tables of the tip RMSE for parameter errors, noise and loads x trajectories x controllers;
    /// for inertia errors with the paper's values
    Table(table::TableArgs),
    /// Write the evaluation as one HTML file with tables, plots and a 3-D animation
    Report(pictures::ReportArgs),
    /// One-axis experiment: lift and tilt actuator against load emulators that replay the forces of
    /// the machine
    Testbed(testbed::TestbedArgs),
    /// Stability proof in numbers: accompanying functions, bound and excess, gain conditions
    Stability(stability::StabilityArgs),
    /// Energy of each actuator: electrical, losses by kind, work, regeneration, efficiency; of
    /// their supply, back to its source
    Energy(energy::EnergyArgs),
    /// Loads of motors and actuators compared with their ratings: RMS and peaks, envelopes,
    /// temperatures over an hour, sensitivity to the payload
    Sizing(sizing::SizingArgs),
    /// Long run with a reference that never ends; fails if memory, time, tracking or estimates degrade
    Endurance(endurance::EnduranceArgs),
    /// Tune each control law by the same method on some drawn machines and compare them on others
    Tournament(tournament::TournamentArgs),
    /// How far each law is from instability: in delay, loop gain, mounting, inertia, adaptation
    Margins(margins::MarginsArgs),
    /// Whether the machine rests after a push, in random poses, with any payload, under each law
    Rest(rest::RestArgs),
    /// Many machines drawn at random under one law: kept, stopped, lost, and the rods' forces
    Draws(draws::DrawsArgs),
    /// Payloads of all sizes and places with and without weighing of the hook: errors of both
    Weighing(weighing::WeighingArgs),
    /// Single faults of sensors, wires and drives: kept, stopped in time, or lost
    Faults(faults::FaultsArgs),
    /// Tip error, tracking, orientation and verdict of a run that another importer wrote as CSV
    Evaluate(evaluate::EvaluateArgs),
    /// Draw the signals of a CSV file over time, as PNG and SVG
    Plot(pictures::PlotArgs),
    /// Check, draw, scale and write machine files
    #[command(subcommand)]
    Machine(machine::MachineCommand),
    /// Describe paths of the tip and check whether a machine can follow them
    #[command(subcommand)]
    Path(path::PathCommand),
    /// Train the actuator's surrogate network on a CSV file; Ctrl-C keeps the state for --resume
    #[command(disable_help_flag = true)]
    Train(OtherArguments),
    /// Tools for the training: virtual testbed, efficiency map, plots and comparison of the network
    #[command(disable_help_flag = true)]
    Surrogate(OtherArguments),
}

impl Command {
    /// The package of the program that executes the command, if that is not `hdrm-fmu`.
    pub fn sibling(&self) -> Option<&'static str> {
        use machine::MachineCommand::{Draw, Scene};
        let is_drawn = match self {
            Self::Train(_) | Self::Surrogate(_) => return Some("surrogate"),
            Self::Report(_) | Self::Plot(_) | Self::Machine(Draw(_) | Scene(_)) => true,
            Self::Sizing(args) => args.figures.is_some(),
            Self::Path(path::PathCommand::Check(args)) => args.figures.is_some(),
            _ => false,
        };
        is_drawn.then_some("report")
    }

    /// Whether the command runs the bending plant, which is written in Python.
    pub fn needs_python(&self) -> bool {
        match self {
            Self::Table(args) => args.world.bends(),
            Self::Report(args) => args.bending,
            _ => false,
        }
    }
}

/// What a command ended with: whether a bad verdict means exit code 2, and the verdict.
pub type Ending = (bool, Result<Verdict>);

/// Runs a command, in a process with Python's library if it needs Python.
pub fn run(needs_python: bool, command: impl FnOnce() -> Ending) -> ExitCode {
    if needs_python {
        match python::with_python() {
            Ok(None) => {}
            Ok(Some(status)) => return exit_code(status),
            Err(error) => return exit(Err(error), false),
        }
    }
    let prepared = (interrupt::install().map_err(Into::into)).and_then(|()| claim_outputs());
    let (check, verdict) = match prepared {
        Ok(()) => command(),
        Err(error) => (false, Err(error)),
    };
    exit(verdict, check)
}

/// Arguments that another program reads, `--help` included.
#[derive(Args)]
pub struct OtherArguments {
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        value_name = "OPTIONS"
    )]
    _arguments: Vec<OsString>,
}

/// Runs the program of `package`, in the folder of this one; returns its exit code.
pub fn run_sibling(package: &str, arguments: &[OsString]) -> Result<ExitCode> {
    let name = format!("hdrm-fmu-{package}");
    let own = env::current_exe().context("path of this program")?;
    let program = own.with_file_name(format!("{name}{EXE_SUFFIX}"));
    ensure!(
        program.is_file(),
        "this is done by the program `{name}`, which is not beside this one, at {}; in this project's sources it is built by `cargo build \
         --release --package {package}`",
        program.display()
    );
    let arguments = match arguments {
        [word, rest @ ..] if word == "surrogate" => rest,
        all => all,
    };
    let mut command = process::Command::new(&program);
    command.args(arguments);
    start(&mut command).with_context(|| program.display().to_string())
}

/// On Unix the program replaces this process, so that signals reach it.
#[cfg(unix)]
fn start(command: &mut process::Command) -> Result<ExitCode> {
    use std::os::unix::process::CommandExt as _;
    Err(command.exec().into())
}

/// Elsewhere this process waits for it; Ctrl-C reaches both, but only the program acts on it.
#[cfg(not(unix))]
fn start(command: &mut process::Command) -> Result<ExitCode> {
    use signal_hook::consts::SIGINT;
    signal_hook::flag::register(SIGINT, std::sync::Arc::default())?;
    Ok(exit_code(command.status()?))
}

/// The exit code of a program that ended; 1 if a signal ended it or the code does not fit.
fn exit_code(status: process::ExitStatus) -> ExitCode {
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    ExitCode::from(code.unwrap_or(1))
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
