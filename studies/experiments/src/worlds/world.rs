//! The choice `--world`, for commands, report and Python: each world's packed system and parameter
//! sets, and the cases (rows of the tables) on which control laws are compared.

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::ValueEnum;
use cosim::System;
use serde::Serialize;

use super::perturbation::{Bounds, Cases};
use super::strict;
use crate::runs::grid::{ALL_TRAJECTORIES, Case, TRAJECTORIES};

/// Packed system of the ideal world.
pub const MACHINE: &str = "Manipulator.ssp";
/// Packed system of the real world.
pub const SYSTEM: &str = "Real.ssp";
/// Parameter set of the real world: other gains, and the delay in the controller.
pub const PARAMETERS: &str = "resources/real.ssv";
/// Shipped machines that have their own parameter set of the real world.
const OWN_PARAMETER_SETS: [(&str, &str); 1] = [("hiab_xs031", "resources/real_hiab_xs031.ssv")];
/// Default number of drawn machines.
const SEEDS: u64 = 20;
/// Inertia scales of the ideal world, in the order of the paper's table.
pub const SCALES: [f64; 5] = [1.4, 1.2, 1.0, 0.8, 0.6];
/// Packed system of the bending world.
pub const BENDING_SYSTEM: &str = "Bending.ssd";
/// Largest communication step of the bending world, s: with 1 ms the exchange between an actuator
/// and the light end of a bending boom is unstable.
pub const BENDING_STEP: f64 = 5e-4;
/// Default number of drawn machines that bend: their runs take about ten times as long.
const BENDING_SEEDS: u64 = 5;
/// Bound of the tip error by the controller's own rigid kinematics in the bending world, m.
pub const BENDING_TARGET: f64 = 2e-3;

/// A world.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum World {
    /// The controller's own model with all inertias scaled by one factor: a check of the code
    Ideal,
    /// Actuators as built, sensors, a step of delay, machine errors by seed, all unknown to control
    Real,
    /// A structure that bends, in MuJoCo, with errors drawn by seed; steps of at most 0.5 ms
    Bending,
    /// The real world with errors of motors, screws, friction, mounting, joints, wrist drives, load
    /// cells and clock drawn by seed
    StrictRigid,
    /// The structure that bends, with actuators as built and sensors, parameters drawn by seed
    Strict,
}

impl World {
    /// Name on the command line.
    pub fn name(self) -> String {
        value_name(self)
    }

    /// Its packed system.
    pub fn system(self) -> &'static str {
        match self {
            Self::Ideal => MACHINE,
            Self::Real | Self::StrictRigid => SYSTEM,
            Self::Bending => BENDING_SYSTEM,
            Self::Strict => strict::SYSTEM,
        }
    }

    /// Fails if `system` is the packed system of another world: its results would go by a wrong name.
    pub fn refuse_other(self, system: &Path) -> Result<()> {
        let is_of = |world: &Self| system.file_name() == Some(world.system().as_ref());
        let other = Self::value_variants().iter().find(|world| is_of(world));
        if let (Some(other), false) = (other, is_of(&self)) {
            bail!(
                "{} is the system of --world {}, not of --world {}",
                system.display(),
                other.name(),
                self.name()
            );
        }
        Ok(())
    }

    /// Whether its plant bends; such a plant is computed by MuJoCo in Python.
    pub fn bends(self) -> bool {
        matches!(self, Self::Bending | Self::Strict)
    }

    /// Whether its system is that of the real world.
    pub fn is_as_built(self) -> bool {
        matches!(self, Self::Real | Self::StrictRigid)
    }

    /// The trajectories on which laws are compared.
    pub fn trajectories(self) -> &'static [&'static str] {
        match self {
            Self::Ideal | Self::Real | Self::Bending => &TRAJECTORIES,
            Self::StrictRigid | Self::Strict => &ALL_TRAJECTORIES,
        }
    }

    /// Default number of drawn machines.
    pub fn default_seeds(self) -> u64 {
        match self {
            Self::Bending | Self::Strict => BENDING_SEEDS,
            Self::Ideal | Self::Real | Self::StrictRigid => SEEDS,
        }
    }
}

/// Name of a value on the command line.
pub(crate) fn value_name(value: impl ValueEnum) -> String {
    let value = value.to_possible_value().expect("no value is skipped");
    value.get_name().to_owned()
}

/// The cases of a world: for `ideal` the inertia errors of the paper's table, for the others one
/// machine for each seed. Machine errors that are drawn here have `factor` times the usual bounds.
pub fn cases(world: World, system: &System, seeds: Range<u64>, factor: f64) -> Result<Cases> {
    let mut cases = match world {
        World::Ideal => inertia_cases(system)?.into(),
        World::Real | World::StrictRigid => {
            Cases::draw_machines(system, seeds, &Bounds::REAL.times(factor))?
        }
        World::Bending | World::Strict => plant_seed_cases(system, seeds)?.into(),
    };
    if matches!(world, World::StrictRigid | World::Strict) {
        strict::add_strict_errors(system, &mut cases.list, world.bends())?;
    }
    Ok(cases)
}

fn inertia_cases(system: &System) -> Result<Vec<Case>> {
    let case = |scale: f64| {
        let label = format!("inertia {:+.0} %", 100.0 * (scale - 1.0));
        let setting = system.setting("inertia_scale", scale)?;
        Ok(Case::new(label, vec![setting]))
    };
    SCALES.into_iter().map(case).collect()
}

fn plant_seed_cases(system: &System, seeds: Range<u64>) -> Result<Vec<Case>> {
    let case = |seed| {
        let setting = system.setting("hdrm.seed", seed)?;
        Ok(Case::from_seed(seed, vec![setting]))
    };
    seeds.map(case).collect()
}

/// The real world's parameter set for the shipped machine `name` or one that extends it; for any
/// other machine that of the reference machine.
pub fn parameter_set_of(name: Option<&str>) -> &'static str {
    let own = OWN_PARAMETER_SETS
        .iter()
        .find(|(own, _)| name == Some(*own));
    own.map_or(PARAMETERS, |(_, file)| file)
}

/// The parameter sets without those that the real world takes by itself.
pub fn without_worlds(sets: &[PathBuf]) -> Vec<PathBuf> {
    let own = OWN_PARAMETER_SETS.iter().map(|(_, file)| *file);
    let own = Vec::from_iter(own.chain([PARAMETERS]).map(Path::new));
    let sets = sets.iter().filter(|set| !own.contains(&set.as_path()));
    sets.cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_parameter_set_of_a_machine_exists_and_is_found_by_its_name() {
        let system = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../system");
        for (name, file) in OWN_PARAMETER_SETS {
            assert!(machine_file::preset(name).is_some(), "{name}");
            assert!(system.join(file).is_file(), "{file}");
            assert_eq!(parameter_set_of(Some(name)), file);
        }
        for name in [None, Some("reference"), Some("sized")] {
            assert_eq!(parameter_set_of(name), PARAMETERS);
        }
    }
}
