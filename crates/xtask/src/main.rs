//! `cargo xtask`: builds, describes, packs, demonstrates, tests and measures the FMU suite. `cargo xtask help` lists the commands.

mod bench;
mod demo;
mod describe;
mod dist;
mod fuzz;
mod importers;
mod libclang;
mod nightly;
mod pack;
mod phases;
mod python;
mod sanitize;
mod test;
mod torture;
mod variants;
mod wheel;
mod workspace;

use std::path::PathBuf;
use std::process::{Command as Process, ExitCode};

use anyhow::Result;
use cargo_fmu::pack::Platforms;
use cargo_fmu::process::execute;
use cargo_fmu::workspace::Source;
use clap::{Parser, Subcommand};
use workspace::Workspace;

/// Build, pack, demonstrate, test and measure the FMU suite.
#[derive(Parser)]
#[command(bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write modelDescription/*.xml from the built libraries
    Describe {
        /// Write nothing; fail when a committed file differs from what the library says
        #[arg(long)]
        check: bool,
    },
    /// Build the FMU crates and pack target/fmu/*.fmu and Manipulator.ssp
    Pack {
        /// Directory for the packed files [default: fmu/ in the cargo target directory]
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Pack this package's cdylib instead of the suite, repeatable
        #[arg(short, long = "package", value_name = "PACKAGE")]
        packages: Vec<String>,
        /// Pack this cdylib example instead of the suite, repeatable
        #[arg(long = "example", value_name = "EXAMPLE")]
        examples: Vec<String>,
        /// Cargo profile of the libraries; `release` builds faster and runs slower
        #[arg(long, value_name = "PROFILE", default_value = workspace::FMU_PROFILE)]
        profile: String,
    },
    /// What is handed out: FMUs that hold libraries for several platforms, systems, programs, notices, checksums
    Dist(dist::Options),
    /// The Python package `hdrm_fmu` as a wheel, with the packed FMUs inside
    Wheel(wheel::Options),
    /// From a fresh checkout to the coupled machine: build, pack, run the cubic trajectory with three controllers
    Demo,
    /// Everything that CI checks
    Test,
    /// One table of what everything costs, beside other engines; or instruction counts against the recorded ones
    Bench(bench::Options),
    /// Mistreat the FMUs: random calls, sanitizers, valgrind, threads, fuzzing, long runs
    Torture(torture::Options),
    /// Provide libclang, so that plain `cargo build -p cosim` works
    Setup,
    /// Run the co-simulation program: `cargo xtask cosim -- run --help`
    Cosim {
        /// Arguments of `cosim`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Run the manipulator's experiments: `cargo xtask hdrm-fmu -- table --help`
    HdrmFmu {
        /// Arguments of `hdrm-fmu`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
}

fn main() -> ExitCode {
    match run(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> Result<()> {
    let workspace = Workspace::find()?;
    let caller = std::env::current_dir()?;
    match command {
        Command::Describe { check } => describe::run(&workspace, check),
        Command::Pack {
            out,
            packages,
            examples,
            profile,
        } => {
            let out = caller.join(out.unwrap_or_else(|| workspace.fmu_dir()));
            let sources = Source::chosen(packages, examples);
            if sources.is_empty() {
                pack::suite_with(&workspace, &profile, &Platforms::default(), &out).map(drop)
            } else {
                pack::fmus(&workspace, &sources, &profile, &out).map(drop)
            }
        }
        Command::Dist(options) => dist::run(&workspace, &caller, options),
        Command::Wheel(options) => wheel::run(&workspace, &caller, &options),
        Command::Demo => demo::run(&workspace),
        Command::Test => test::run(&workspace),
        Command::Bench(options) => bench::run(&workspace, &options),
        Command::Torture(options) => torture::run(&workspace, &options),
        Command::Setup => libclang::provide(&workspace).map(drop),
        Command::Cosim { arguments } => {
            let cosim = libclang::build_cosim(&workspace)?;
            // In the caller's folder, so that paths are as the shell means them.
            execute(Process::new(cosim).args(arguments))
        }
        Command::HdrmFmu { arguments } => {
            let hdrm_fmu = libclang::build_hdrm_fmu(&workspace)?;
            execute(Process::new(hdrm_fmu).args(arguments))
        }
    }
}
