//! Subcommands, and the arguments that they share.

pub mod evaluation;
pub mod report;
pub mod run;

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use cosim::cli::{self, SystemArgs, find};
use cosim::run::Experiment;
use cosim::system::System;

/// The machine and how it is run.
#[derive(Args)]
pub struct MachineArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    run: cli::RunArgs,
}

impl MachineArgs {
    /// The machine and the experiment that the arguments describe.
    fn load(&self) -> Result<(System, Experiment)> {
        let system = self.system.load(|| packed("Manipulator.ssp"))?;
        let experiment = self.run.experiment(&system)?;
        Ok((system, experiment))
    }
}

/// A packed system of the suite, where the program finds it by itself.
fn packed(name: &str) -> Result<PathBuf> {
    find(name, "FMU_DIR")
}
