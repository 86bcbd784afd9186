//! The program `torture`: mistreats FMUs of FMI 2.0 and 3.0 and checks that they withstand it. The
//! scripts `tests/robustness.py` and `tests/handed_out.py` run it.
//!
//! `calls`: random calls over all 34 functions of FMI 2.0, or those of FMI 3.0, with any arguments
//! of the right C types, against an oracle made of the standard's call order and the FMU's own
//! model description; each batch in a process of its own, so that a crash or a hang is caught, its
//! last calls are printed, and it can be replayed by its seed. `exchange`: random calls of Model
//! Exchange. `life`: loads, instances, saved states and unloads, for valgrind. `threads`: instances
//! in parallel threads, for helgrind. `long`: many steps; memory, time and outputs are checked.
//! `save` and `continue`: states carried to another process or platform.
//!
//! It works on any packed FMU. FMUs made with `fmu-export` pass all checks, also that a refused
//! call changes nothing and that messages name what was wrong.
#![forbid(unsafe_code)]
#![allow(clippy::missing_errors_doc)] // a program: every error is printed

mod arguments;
mod batches;
mod derivative_calls;
mod endurance;
mod fmi3_calls;
mod life;
mod lifecycle_calls;
mod model_exchange_calls;
mod oracle;
mod random;
mod session;
mod state_calls;
mod subject;
mod threads;
mod transfer;
mod turns;
mod value_calls;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Args, Parser, Subcommand};

#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// The FMUs under test.
#[derive(Args)]
struct Fmus {
    /// Packed FMUs, or libraries made with fmu-export
    #[arg(required = true)]
    fmus: Vec<PathBuf>,
}

impl Fmus {
    /// Calls `act` for one after the other; an error names the FMU.
    fn each(&self, act: impl Fn(&Path) -> Result<()>) -> Result<()> {
        let named = |path: &PathBuf| act(path).with_context(|| path.display().to_string());
        self.fmus.iter().try_for_each(named)
    }
}

#[derive(Subcommand)]
enum Command {
    /// Random calls in batches, each in a process of its own
    Calls {
        #[command(flatten)]
        fmus: Fmus,
        /// Calls in total
        #[arg(long, default_value_t = 1_000_000)]
        calls: usize,
        /// Calls of one batch
        #[arg(long, default_value_t = 20_000)]
        batch: usize,
        /// Seed of the first batch
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Processes at a time [default: number of cores]
        #[arg(long)]
        jobs: Option<usize>,
        /// Repeat this batch only, printing every call before it is made
        #[arg(long, value_name = "SEED")]
        replay: Option<u64>,
    },
    /// Random calls of instances for Model Exchange
    Exchange {
        #[command(flatten)]
        fmus: Fmus,
        /// Calls of each FMU
        #[arg(long, default_value_t = 200_000)]
        calls: usize,
        /// Seed
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// One batch, in this process
    #[command(hide = true)]
    Batch {
        #[command(flatten)]
        fmus: Fmus,
        #[arg(long)]
        calls: usize,
        #[arg(long)]
        seed: u64,
        #[arg(long)]
        trace: bool,
    },
    /// Loads, instances with steps and saved states, unloads
    Life {
        #[command(flatten)]
        fmus: Fmus,
        /// Instances of each FMU
        #[arg(long, default_value_t = 2000)]
        instances: usize,
        /// Times each library is loaded and unloaded
        #[arg(long, default_value_t = 5)]
        loads: usize,
    },
    /// Instances of all FMUs in parallel threads, compared with one alone
    Threads {
        #[command(flatten)]
        fmus: Fmus,
        /// Threads for each FMU
        #[arg(long, default_value_t = 4)]
        threads: usize,
        /// Steps of each instance
        #[arg(long, default_value_t = 200)]
        steps: usize,
        /// Make an instance of each FMU before the threads start and keep it until they have ended
        #[arg(long)]
        warm: bool,
    },
    /// Run each FMU, save its state in the middle, and write the state and the numbers that
    /// followed into a folder
    Save {
        #[command(flatten)]
        fmus: Fmus,
        /// The folder
        #[arg(long, value_name = "DIR")]
        to: PathBuf,
    },
    /// Continue from states that were saved, perhaps on another platform; the numbers that follow
    /// must be the same
    Continue {
        #[command(flatten)]
        fmus: Fmus,
        /// The folder
        #[arg(long, value_name = "DIR")]
        from: PathBuf,
    },
    /// Many steps of 1 ms with moving inputs
    Long {
        #[command(flatten)]
        fmus: Fmus,
        /// Steps of each FMU
        #[arg(long, default_value_t = 100_000)]
        steps: u64,
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
    match command {
        Command::Calls {
            fmus: Fmus { fmus },
            calls,
            batch,
            seed,
            jobs,
            replay,
        } => match replay {
            Some(seed) => batches::replay(&fmus, batch, seed),
            None => batches::run(&fmus, calls, batch, seed, jobs),
        },
        Command::Batch {
            fmus,
            calls,
            seed,
            trace,
        } => batches::run_here(&fmus.fmus, calls, seed, trace),
        Command::Exchange { fmus, calls, seed } => {
            fmus.each(|path| model_exchange_calls::run(path, calls, seed))
        }
        Command::Life {
            fmus,
            instances,
            loads,
        } => fmus.each(|path| life::run(path, instances, loads)),
        Command::Threads {
            fmus,
            threads,
            steps,
            warm,
        } => threads::run(&fmus.fmus, threads, steps, warm),
        Command::Save { fmus, to } => fmus.each(|path| transfer::save(path, &to)),
        Command::Continue { fmus, from } => fmus.each(|path| transfer::continue_from(path, &from)),
        Command::Long { fmus, steps } => fmus.each(|path| endurance::run(path, steps)),
    }
}
