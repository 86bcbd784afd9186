//! Command line of the manipulator's experiments, which the programs share: each does its part.

use clap::{Parser, Subcommand};

use super::program::{OtherArguments, Sibling};
use super::{
    compare, draws, endurance, energy, evaluate, machine, margins, path, pictures, run, sizing,
    stability, table, testbed, tournament,
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
    Run(run::RunArgs),
    /// Run one trajectory with the three controllers and print their tip RMSE beside the paper's
    Compare(compare::CompareArgs),
    /// Tip RMSE for parameter errors, noise and loads x trajectories x controllers, for inertia
    /// errors beside the paper's
    Table(table::TableArgs),
    /// Write the evaluation as one HTML file with tables, plots and a 3-D animation
    Report(pictures::ReportArgs),
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
    Plot(pictures::PlotArgs),
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

impl Command {
    /// The program that does it, where it is not `hdrm-fmu`.
    pub fn sibling(&self) -> Option<Sibling> {
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

    /// Whether it runs the plant that bends, which is written in Python.
    pub fn needs_python(&self) -> bool {
        match self {
            Self::Table(args) => args.world.bends(),
            Self::Report(args) => args.bending,
            _ => false,
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
