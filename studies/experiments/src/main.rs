//! Program `hdrm-fmu`, the command line of the experiments: runs a command or a sibling program.
#![forbid(unsafe_code)]

use std::env;
use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser as _;
use cosim::Verdict;
use cosim::cli::{exit, serve_if_asked};
use experiments::commands::program::{Cli, Command, Ending};
use experiments::commands::{
    compare, draws, endurance, energy, evaluate, faults, machine, margins, path, program, rest,
    run, sizing, stability, table, testbed, tournament, weighing,
};

fn main() -> ExitCode {
    if let Some(code) = serve_if_asked() {
        return code;
    }
    let arguments = arguments();
    let command = Cli::parse_from(&arguments).command;
    if let Some(package) = command.sibling() {
        return program::run_sibling(package, &arguments[1..])
            .unwrap_or_else(|error| exit(Err(error), false));
    }
    program::run(command.needs_python(), || run(&command))
}

/// The arguments, with `help COMMAND` rewritten to `COMMAND --help`, so that the program that does
/// the command explains it.
fn arguments() -> Vec<OsString> {
    let mut arguments: Vec<_> = env::args_os().collect();
    if arguments.get(1).is_some_and(|word| word == "help") {
        arguments.remove(1);
        arguments.push("--help".into());
    }
    arguments
}

fn run(command: &Command) -> Ending {
    let done = |result: Result<()>| (false, result.map(|()| Verdict::default()));
    match command {
        Command::Run(args) => (args.machine.check(), run::run(args)),
        Command::Compare(args) => (args.machine.check(), compare::compare(args)),
        Command::Table(args) => (args.machine.check(), table::table(args)),
        Command::Testbed(args) => (args.machine.check(), testbed::testbed(args)),
        Command::Stability(args) => (args.machine.check(), stability::stability(args)),
        Command::Energy(args) => (args.machine.check(), energy::energy(args)),
        Command::Sizing(args) => {
            let verdict = sizing::sizing(args).map(|(verdict, _)| verdict);
            (args.machine.check(), verdict)
        }
        Command::Endurance(args) => (args.machine.check(), endurance::endurance(args)),
        Command::Rest(args) => (args.machine.check(), rest::rest(args)),
        Command::Weighing(args) => (args.machine.check(), weighing::weighing(args)),
        Command::Draws(args) => (args.machine.check(), draws::draws(args)),
        Command::Faults(args) => (args.machine.check(), faults::faults(args)),
        Command::Tournament(args) => (args.machine.check(), tournament::tournament(args)),
        Command::Margins(args) => (args.machine.check(), margins::margins(args)),
        Command::Evaluate(args) => (args.machine.check(), evaluate::evaluate(args)),
        Command::Machine(command) => done(machine::run(command)),
        Command::Path(command) => done(path::run(command)),
        Command::Report(_) | Command::Plot(_) | Command::Train(_) | Command::Surrogate(_) => {
            unreachable!("done by another program")
        }
    }
}
