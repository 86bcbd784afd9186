//! Subcommands, and the arguments that they share.

pub mod electric;
pub mod elsewhere;
pub mod evaluation;
pub mod machine;
pub mod path;
pub mod program;
pub mod python;
pub mod run;
pub mod siblings;
pub mod worlds;

use std::path::Path;

use crate::experiment::{over, tell_delay};
use crate::worlds::{BENDING_STEP, BENDING_SYSTEM, SYSTEM, World, parameters_of};
use crate::{loads, machine_file, path_margins};
use ::machine::Source;
use anyhow::{Context as _, Result};
use clap::Args;
use cosim::cli::{self, SystemArgs, find};
use cosim::run::Experiment;
use cosim::system::{Setting, System};
use cosim::verdict::Verdict;
use tip_path::PathFile;

/// The packed machine.
const MACHINE: &str = "Manipulator.ssp";

/// The machine and how it is run.
#[derive(Args)]
pub struct MachineArgs {
    #[command(flatten)]
    system: SystemArgs,
    /// Machine file, or name of a shipped machine, for all FMUs: the `machine_file` of every component that has one
    #[arg(long = "machine", value_name = "FILE|NAME")]
    file: Option<String>,
    #[command(flatten)]
    run: cli::RunArgs,
    /// Path that the tip follows: a JSON or CSV file of waypoints or samples, or iso9283-cube, iso9283-rectangle; without a stop time, to its end
    #[arg(long, value_name = "FILE")]
    waypoints: Option<String>,
}

impl MachineArgs {
    /// The machine, the experiment that the arguments describe, and what the system may have forgotten.
    fn load(&self) -> Result<(System, Experiment, Verdict)> {
        self.on(self.system(&self.system, MACHINE)?)
    }

    /// The system that `arguments` describe, by default `default`, with the machine that was asked for, and with wires for the loads of the path.
    fn system(&self, arguments: &SystemArgs, default: &str) -> Result<System> {
        let mut system = self.without_loads(arguments, default)?;
        if self.carries()? {
            loads::connect(&mut system)?;
        }
        Ok(system)
    }

    /// The same without wires for loads, as the systems that run beside the one on the path need none.
    fn without_loads(&self, arguments: &SystemArgs, default: &str) -> Result<System> {
        let mut system = arguments.load(|| find(default))?;
        if let Some(machine) = &self.file {
            machine_file::bind(&mut system, machine)
                .with_context(|| format!("--machine {machine}"))?;
        }
        Ok(system)
    }

    /// Whether loads are picked up on the path that is given.
    fn carries(&self) -> Result<bool> {
        let path = self.waypoints.as_deref().map(path_margins::read);
        Ok(path.transpose()?.is_some_and(|path| loads::are_on(&path)))
    }

    /// The parameter set of the real world that belongs to the machine.
    fn parameters(&self) -> Result<&'static str> {
        let source = self.file.as_deref().map(Source::named).transpose()?;
        Ok(parameters_of(source.and_then(|source| source.shipped())))
    }

    /// As [`MachineArgs::load`], whatever path is given.
    pub fn load_without_path(&self) -> Result<(System, Experiment, Verdict)> {
        self.without_path(self.system(&self.system, MACHINE)?)
    }

    /// The path that is given by its name, and the experiment that follows it.
    pub fn on_path(
        &self,
        system: &System,
        base: &Experiment,
    ) -> Result<Option<(String, Experiment)>> {
        let follow = |path: &String| {
            let experiment = over(system, base, follow(system, path)?)?;
            Ok((path.clone(), experiment))
        };
        self.waypoints.as_ref().map(follow).transpose()
    }

    fn on(&self, system: System) -> Result<(System, Experiment, Verdict)> {
        let (system, base, verdict) = self.without_path(system)?;
        let experiment = self
            .on_path(&system, &base)?
            .map_or(base, |(_, experiment)| experiment);
        Ok((system, experiment, verdict))
    }

    fn without_path(&self, system: System) -> Result<(System, Experiment, Verdict)> {
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
                let mut system = self.system(&self.system, SYSTEM)?;
                system.apply_set(Path::new(self.parameters()?))?;
                self.on(system)
            }
            World::Bending => {
                let system = self.system(&self.system, BENDING_SYSTEM)?;
                let (system, mut base, verdict) = self.on(system)?;
                base.stepping.step = base.stepping.step.min(BENDING_STEP);
                Ok((system, base, verdict))
            }
        }
    }

    /// The machine of the real world in `path`, with its parameter set.
    pub fn real(&self, path: &Path) -> Result<System> {
        let mut system = self.beside(path)?;
        system.apply_set(Path::new(self.parameters()?))?;
        Ok(system)
    }

    /// Another packed system, with the FMUs from the same place.
    pub fn beside(&self, path: &Path) -> Result<System> {
        let arguments = SystemArgs {
            system: Some(path.into()),
            variant: None,
            parameters: Vec::new(),
            ..self.system.clone()
        };
        self.without_loads(&arguments, MACHINE)
    }

    /// The path that the tip follows, where one is given.
    pub fn waypoints(&self) -> Option<&str> {
        self.waypoints.as_deref()
    }

    /// Whether a bad verdict ends the program with a code of its own.
    pub fn check(&self) -> bool {
        self.run.check
    }
}

/// The start values with which the controller follows a path.
fn follow(system: &System, path: &str) -> Result<Vec<Setting>> {
    let controller = system.component_of(system.port("trajectory")?);
    let file = match PathFile::built_in(path) {
        Some(_) => path.to_owned(),
        None => std::path::absolute(path)?.display().to_string(),
    };
    Ok(vec![
        system.setting(&format!("{controller}.trajectory"), "path")?,
        system.setting(&format!("{controller}.path_file"), file)?,
    ])
}
