//! Command line of the manipulator's experiments.
#![forbid(unsafe_code)]

mod commands;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use commands::{electric, elsewhere, evaluation, machine, path, plot, python, report, run};
use cosim::cli::{code, exit};
use cosim::verdict::Verdict;
use studies::worlds::World;

/// Experiments on the coupled manipulator: three electromechanical actuators, rigid bodies and controller, as FMUs.
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
    Compare(run::CompareArgs),
    /// Tip RMSE for parameter errors, noise and loads x trajectories x controllers, for inertia errors beside the paper's
    Table(evaluation::TableArgs),
    /// Write the evaluation as one HTML file with tables, plots and a 3-D animation
    Report(report::ReportArgs),
    /// One-axis experiment: lift and tilt actuator against load emulators that replay the forces of the machine
    Testbed(evaluation::TestbedArgs),
    /// Stability proof in numbers: accompanying functions, bound and excess, gain conditions
    Stability(evaluation::StabilityArgs),
    /// Energy of each actuator: electrical, losses by kind, work, regeneration, efficiency; of what feeds them, back to its source
    Energy(electric::EnergyArgs),
    /// Motors and actuators beside what they do: RMS and peaks, envelopes, temperatures over an hour, sensitivity to the payload
    Sizing(electric::SizingArgs),
    /// Long run with a reference that never ends: memory, time, tracking and estimates; fails where one of them does not endure
    Endurance(evaluation::EnduranceArgs),
    /// Tip error, tracking, orientation and verdict of a run that another importer made and wrote as CSV
    Evaluate(elsewhere::EvaluateArgs),
    /// Draw the signals of a CSV file over time, as PNG and SVG
    Plot(plot::PlotArgs),
    /// What is done to machine files
    #[command(subcommand)]
    Machine(machine::MachineCommand),
    /// Paths of the tip: what they are, and whether a machine can do them
    #[command(subcommand)]
    Path(path::PathCommand),
    /// Train the actuator's surrogate network on a CSV file; Ctrl-C keeps the state, --resume goes on
    Train(surrogate::commands::TrainArgs),
    /// What belongs to the training: virtual testbed, efficiency map, plots and comparison of the network
    #[command(subcommand)]
    Surrogate(surrogate::commands::Command),
}

fn main() -> ExitCode {
    let command = Cli::parse().command;
    let check = command.check();
    if command.needs_python() {
        match python::with_python() {
            Ok(None) => {}
            // Code 1 too where a signal ended it.
            Ok(Some(ended)) => {
                let code = ended.code().and_then(|code| u8::try_from(code).ok());
                return ExitCode::from(code.unwrap_or(1));
            }
            Err(error) => return exit(Err(error), check),
        }
    }
    let done = |result: Result<()>| result.map(|()| Verdict::default());
    let result = match command {
        Command::Run(args) => run::run(&args),
        Command::Compare(args) => run::compare(&args),
        Command::Table(args) => evaluation::tables(&args),
        Command::Report(args) => report::report(&args),
        Command::Testbed(args) => evaluation::run_testbed(&args),
        Command::Stability(args) => evaluation::run_stability(&args),
        Command::Energy(args) => electric::energy(&args),
        Command::Sizing(args) => electric::sizing(&args),
        Command::Endurance(args) => evaluation::run_endurance(&args),
        Command::Evaluate(args) => elsewhere::evaluate(&args),
        Command::Plot(args) => done(plot::plot(&args)),
        Command::Machine(command) => done(machine::run(&command)),
        Command::Path(command) => done(path::run(&command)),
        Command::Train(args) => done(args.run()),
        Command::Surrogate(command) => done(command.run()),
    };
    let code = code(result, check);
    python::end(code);
    ExitCode::from(code)
}

impl Command {
    /// Whether it runs the plant that bends, which is written in Python.
    fn needs_python(&self) -> bool {
        match self {
            Self::Table(args) => args.world == World::Bending,
            Self::Report(args) => args.bending,
            _ => false,
        }
    }

    /// Whether a bad verdict ends the program with a code of its own.
    fn check(&self) -> bool {
        let machine = match self {
            Self::Run(args) => &args.machine,
            Self::Compare(args) => &args.machine,
            Self::Table(args) => &args.machine,
            Self::Report(args) => &args.machine,
            Self::Testbed(args) => &args.machine,
            Self::Stability(args) => &args.machine,
            Self::Energy(args) => &args.machine,
            Self::Sizing(args) => &args.machine,
            Self::Endurance(args) => &args.machine,
            Self::Evaluate(args) => &args.machine,
            Self::Plot(_)
            | Self::Machine(_)
            | Self::Path(_)
            | Self::Train(_)
            | Self::Surrogate(_) => {
                return false;
            }
        };
        machine.check()
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    /// Arguments that are defined twice or contradict each other are found here, not by who runs the program.
    #[test]
    fn all_commands_are_well_defined() {
        super::Cli::command().debug_assert();
    }
}
