//! Command line of the manipulator's experiments.
#![forbid(unsafe_code)]

use std::env;
use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use cosim::Verdict;
use cosim::cli::exit;
use studies::commands::program::{Ending, OtherArguments, Sibling};
use studies::commands::{
    compare, draws, endurance, energy, evaluate, machine, margins, path, program, run, sizing,
    stability, table, testbed, tournament,
};

/// Experiments on the coupled manipulator: three electromechanical actuators, rigid bodies and
/// controller, as FMUs.
#[derive(Parser)]
#[command(version, about, long_about = None)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run one experiment and print tip error, power residuals and speed
    Run(run::RunArgs),
    /// Run one trajectory with the three controllers and print their tip RMSE beside the paper's
    Compare(compare::CompareArgs),
    /// Tip RMSE for parameter errors, noise and loads x trajectories x controllers, for inertia
    /// errors beside the paper's
    Table(table::TableArgs),
    /// Write the evaluation as one HTML file with tables, plots and a 3-D animation
    #[command(disable_help_flag = true)]
    Report(OtherArguments),
    /// One-axis experiment: lift and tilt actuator against load emulators that replay the forces of
    /// the machine
    Testbed(testbed::TestbedArgs),
    /// Stability proof in numbers: accompanying functions, bound and excess, gain conditions
    Stability(stability::StabilityArgs),
    /// Energy of each actuator: electrical, losses by kind, work, regeneration, efficiency; of what
    /// feeds them, back to its source
    Energy(energy::EnergyArgs),
    /// Motors and actuators beside what they do: RMS and peaks, envelopes, temperatures over an
    /// hour, sensitivity to the payload
    Sizing(sizing::SizingArgs),
    /// Long run with a reference that never ends: memory, time, tracking and estimates; fails where
    /// one of them does not endure
    Endurance(endurance::EnduranceArgs),
    /// Laws tuned alike, by one tuner on some drawn machines, and compared on others
    Tournament(tournament::TournamentArgs),
    /// How far each law is from instability: in delay, loop gain, mounting, inertia, adaptation
    Margins(margins::MarginsArgs),
    /// Many machines drawn at random under one law: kept, stopped, lost, and the rods' forces
    Draws(draws::DrawsArgs),
    /// Tip error, tracking, orientation and verdict of a run that another importer made and wrote
    /// as CSV
    Evaluate(evaluate::EvaluateArgs),
    /// Draw the signals of a CSV file over time, as PNG and SVG
    #[command(disable_help_flag = true)]
    Plot(OtherArguments),
    /// What is done to machine files
    #[command(subcommand)]
    Machine(machine::MachineCommand),
    /// Paths of the tip: what they are, and whether a machine can do them
    #[command(subcommand)]
    Path(path::PathCommand),
    /// Train the actuator's surrogate network on a CSV file; Ctrl-C keeps the state, --resume goes
    /// on
    #[command(disable_help_flag = true)]
    Train(OtherArguments),
    /// What belongs to the training: virtual testbed, efficiency map, plots and comparison of the
    /// network
    #[command(disable_help_flag = true)]
    Surrogate(OtherArguments),
}

fn main() -> ExitCode {
    let arguments = arguments();
    let command = Cli::parse_from(&arguments).command;
    if let Some(sibling) = command.sibling() {
        return sibling
            .take_over(&arguments[1..])
            .unwrap_or_else(|error| exit(Err(error), false));
    }
    program::run(command.needs_python(), || command.run())
}

/// The arguments, `help` in front of them as `--help` after them: so another program's command is
/// explained by that program.
fn arguments() -> Vec<OsString> {
    let mut arguments: Vec<_> = env::args_os().collect();
    if arguments.get(1).is_some_and(|word| word == "help") {
        arguments.remove(1);
        arguments.push("--help".into());
    }
    arguments
}

impl Command {
    /// The program that does it, where it is not this one.
    fn sibling(&self) -> Option<Sibling> {
        match self {
            Self::Report(_)
            | Self::Plot(_)
            | Self::Machine(machine::MachineCommand::Draw(_) | machine::MachineCommand::Scene(_)) => {
                Some(Sibling::Report)
            }
            Self::Sizing(args) if args.figures.is_some() => Some(Sibling::Report),
            Self::Path(path::PathCommand::Check(args)) if args.figures.is_some() => {
                Some(Sibling::Report)
            }
            Self::Train(_) | Self::Surrogate(_) => Some(Sibling::Surrogate),
            _ => None,
        }
    }

    fn run(&self) -> Ending {
        let done = |result: Result<()>| (false, result.map(|()| Verdict::default()));
        match self {
            Self::Run(args) => (args.machine.check(), run::run(args)),
            Self::Compare(args) => (args.machine.check(), compare::compare(args)),
            Self::Table(args) => (args.machine.check(), table::table(args)),
            Self::Testbed(args) => (args.machine.check(), testbed::testbed(args)),
            Self::Stability(args) => (args.machine.check(), stability::stability(args)),
            Self::Energy(args) => (args.machine.check(), energy::energy(args)),
            Self::Sizing(args) => {
                let verdict = sizing::sizing(args).map(|(verdict, _)| verdict);
                (args.machine.check(), verdict)
            }
            Self::Endurance(args) => (args.machine.check(), endurance::endurance(args)),
            Self::Draws(args) => (args.machine.check(), draws::draws(args)),
            Self::Tournament(args) => (args.machine.check(), tournament::tournament(args)),
            Self::Margins(args) => (args.machine.check(), margins::margins(args)),
            Self::Evaluate(args) => (args.machine.check(), evaluate::evaluate(args)),
            Self::Machine(command) => done(machine::run(command)),
            Self::Path(command) => done(path::run(command)),
            Self::Report(_) | Self::Plot(_) | Self::Train(_) | Self::Surrogate(_) => {
                unreachable!("done by another program")
            }
        }
    }

    /// Whether it runs the plant that bends, which is written in Python.
    fn needs_python(&self) -> bool {
        matches!(self, Self::Table(args) if args.world.bends())
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
