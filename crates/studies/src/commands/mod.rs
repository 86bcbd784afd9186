//! Subcommands, and the arguments that they share.

pub mod electric;
pub mod elsewhere;
pub mod evaluation;
pub mod machine;
pub mod plot;
pub mod python;
pub mod report;
pub mod run;
pub mod worlds;

use std::path::Path;

use anyhow::Result;
use clap::Args;
use cosim::cli::{self, SystemArgs, find};
use cosim::run::Experiment;
use cosim::system::System;
use cosim::verdict::Verdict;
use studies::experiment::tell_delay;
use studies::worlds::{BENDING_STEP, BENDING_SYSTEM, PARAMETERS, SYSTEM, World};

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
        self.on(self.system.load(|| find(MACHINE))?)
    }

    fn on(&self, system: System) -> Result<(System, Experiment, Verdict)> {
        let mut experiment = self.run.experiment(&system)?;
        let verdict = self.run.forgotten(&system, &experiment)?;
        tell_delay(&system, &mut experiment)?;
        Ok((system, experiment, verdict))
    }

    /// As [`MachineArgs::load`], with the machine of `world` where no other is named.
    fn load_world(&self, world: World) -> Result<(System, Experiment, Verdict)> {
        match world {
            World::Ideal => self.load(),
            World::Real => {
                let mut system = self.system.load(|| find(SYSTEM))?;
                system.apply_set(Path::new(PARAMETERS))?;
                self.on(system)
            }
            World::Bending => {
                let system = self.system.load(|| find(BENDING_SYSTEM))?;
                let (system, mut base, verdict) = self.on(system)?;
                base.stepping.step = base.stepping.step.min(BENDING_STEP);
                Ok((system, base, verdict))
            }
        }
    }

    /// The machine of the real world in `path`, with its parameter set.
    fn real(&self, path: &Path) -> Result<System> {
        let mut system = self.beside(path)?;
        system.apply_set(Path::new(PARAMETERS))?;
        Ok(system)
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
