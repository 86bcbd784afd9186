//! `fmu-check`: the program that checks FMUs, for those who make them without Rust.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;
use fmu_check::Arguments;

/// Check FMUs of FMI 2.0 and 3.0: archive, description, libraries, and what they do when they are
/// run
#[derive(Parser)]
#[command(version)]
struct Program {
    #[command(flatten)]
    arguments: Arguments,
}

fn main() -> ExitCode {
    let checked = Program::parse().arguments.run(&[]);
    checked.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}
