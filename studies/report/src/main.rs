//! The program `hdrm-fmu-report`, which draws: the evaluation as one page ([`evaluation`]), a
//! machine on a sheet (crate `machine-sheet`), signals over time ([`plot`]), figures of sizing and of
//! margins along a path; and writes the live page's scene. `hdrm-fmu` starts it with its own
//! arguments; crate `experiments` computes most numbers.
#![forbid(unsafe_code)]

mod commands;
mod evaluation;
mod margins_figure;
mod plot;
mod sizing_figure;

use std::process::ExitCode;

use anyhow::{Result, anyhow};
use clap::Parser as _;
use commands::{drawings, page};
use cosim::Verdict;
use experiments::commands::machine::MachineCommand;
use experiments::commands::path::PathCommand;
use experiments::commands::program::{self, Cli, Command, Ending};

fn main() -> ExitCode {
    let command = Cli::parse().command;
    program::run(command.needs_python(), || run(&command))
}

fn run(command: &Command) -> Ending {
    let done = |result: Result<()>| (false, result.map(|()| Verdict::default()));
    match command {
        Command::Report(args) => (args.machine.check(), page::report(args)),
        Command::Sizing(args) => (args.machine.check(), drawings::sizing(args)),
        Command::Plot(args) => done(drawings::signals(args)),
        Command::Machine(MachineCommand::Draw(args)) => done(drawings::machine(args)),
        Command::Machine(MachineCommand::Scene(args)) => done(drawings::scene(args)),
        Command::Path(PathCommand::Check(args)) => done(drawings::path(args)),
        _ => done(Err(anyhow!("this is done by the program `hdrm-fmu`"))),
    }
}
