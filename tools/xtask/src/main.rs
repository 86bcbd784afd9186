//! `cargo xtask`, for developers and CI: builds, describes, packs, demonstrates, tests and measures
//! the FMU suite. `cargo xtask help` lists the commands.

mod bench;
mod cosim_wasm;
mod demo;
mod describe;
mod dist;
mod importers;
mod pack;
mod phases;
mod programs;
mod python;
mod quick;
mod test;
mod variants;
mod web;
mod wheel;
mod workspace;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use cargo_fmu::pack::Platforms;
use cargo_fmu::process::end;
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
    /// The folder that is handed out: FMUs that hold libraries for several platforms, systems,
    /// programs, notices, checksums
    Dist(dist::Options),
    /// The live machine: one HTML file that runs the coupled system in any browser
    Web(web::Options),
    /// The Python package `hdrm_fmu` as a wheel, with the packed FMUs inside
    Wheel(wheel::Options),
    /// From a fresh checkout to the coupled machine: build, pack, run the cubic trajectory with
    /// three controllers
    Demo,
    /// Format, clippy and the tests of one product, in two minutes once its crates are built
    Quick(quick::Options),
    /// Everything that CI checks
    Test {
        /// Also what takes long to build: libraries for Windows, importers of other makers, the
        /// crates of the kit from their packages
        #[arg(long)]
        nightly: bool,
    },
    /// One table of costs, with other engines for comparison; or instruction counts, compared with
    /// the recorded ones
    Bench(bench::Options),
    /// Mistreat the FMUs: random calls, sanitizers, valgrind, threads, fuzzing, long runs
    #[command(disable_help_flag = true)]
    Torture {
        /// Options of the script; `--help` lists them
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        options: Vec<String>,
    },
    /// Run the co-simulation program: `cargo xtask cosim -- run --help`
    Cosim {
        /// Arguments of `cosim`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Build the program by which `cosim` runs FMUs of WebAssembly, next to it
    CosimWasm,
    /// Run the manipulator's experiments: `cargo xtask hdrm-fmu -- table --help`
    HdrmFmu {
        /// Arguments of `hdrm-fmu`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
}

fn main() -> ExitCode {
    end(run(Cli::parse().command))
}

/// Carries out a command; the exit code is that of the program that it runs, if it runs one.
fn run(command: Command) -> Result<ExitCode> {
    let workspace = &Workspace::find()?;
    let caller = std::env::current_dir()?;
    match command {
        Command::Cosim { arguments } => {
            let program = workspace.build_programs(&["cosim"])?;
            return programs::run(&program, &arguments);
        }
        Command::HdrmFmu { arguments } => {
            let program = workspace.build_programs(&programs::with_started(&arguments))?;
            return programs::run(&program, &arguments);
        }
        Command::CosimWasm => println!("{}", cosim_wasm::build(workspace)?.display()),
        Command::Describe { check } => describe::run(workspace, check)?,
        Command::Pack {
            out,
            packages,
            examples,
            profile,
        } => {
            let out = caller.join(out.unwrap_or_else(|| workspace.fmu_dir()));
            let sources = Source::chosen(packages, examples);
            if sources.is_empty() {
                let profile = workspace::profile(&profile);
                pack::suite_with(workspace, &profile, &Platforms::default(), &out)?;
            } else {
                pack::fmus(workspace, &sources, &profile, &out)?;
            }
        }
        Command::Dist(options) => dist::run(workspace, &caller, options)?,
        Command::Web(options) => web::run(workspace, &caller, &options)?,
        Command::Wheel(options) => wheel::run(workspace, &caller, &options)?,
        Command::Demo => demo::run(workspace)?,
        Command::Quick(options) => quick::run(workspace, &options)?,
        Command::Test { nightly } => test::run(workspace, nightly)?,
        Command::Bench(options) => bench::run(workspace, &options)?,
        Command::Torture { options } => programs::torture(workspace, &options)?,
    }
    Ok(ExitCode::SUCCESS)
}
