//! Subcommands, and the arguments that they share.

pub mod evaluation;
pub mod plot;
pub mod report;
pub mod run;

use std::path::Path;

use anyhow::Result;
use clap::Args;
use cosim::cli::{self, SystemArgs, find};
use cosim::run::Experiment;
use cosim::system::System;
use cosim::verdict::Verdict;
use studies::experiment::tell_delay;

/// The packed machine.
const MACHINE: &str = "Manipulator.ssp";

/// The machine and how it is run.
#[derive(Args)]
pub struct MachineArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    run: cli::RunArgs,
}

impl MachineArgs {
    /// The machine, the experiment that the arguments describe, and what the system may have forgotten.
    fn load(&self) -> Result<(System, Experiment, Verdict)> {
        let system = self.system.load(|| find(MACHINE))?;
        let mut experiment = self.run.experiment(&system)?;
        let verdict = self.run.forgotten(&system, &experiment)?;
        tell_delay(&system, &mut experiment)?;
        Ok((system, experiment, verdict))
    }

    /// Another packed system, with the FMUs from the same place.
    fn beside(&self, path: &Path) -> Result<System> {
        let system = SystemArgs {
            system: Some(path.into()),
            variant: None,
            parameters: Vec::new(),
            ..self.system.clone()
        };
        system.load(|| find(MACHINE))
    }

    /// Whether a bad verdict ends the program with a code of its own.
    pub fn check(&self) -> bool {
        self.run.check
    }
}
