//! What is chosen by `--world`: the plant, and the cases that laws are compared on.

use std::ops::Range;

use anyhow::Result;
use clap::ValueEnum;
use cosim::System;
use serde::Serialize;

use super::perturbation::{Bounds, Cases};
use super::strict;
use crate::runs::grid::{ALL_TRAJECTORIES, Case, TRAJECTORIES};

/// Packed system of the real world.
pub const SYSTEM: &str = "Real.ssp";
/// Its parameter set: what is changed in the controller, and in where the delay is, for this world.
pub const PARAMETERS: &str = "resources/real.ssv";
/// The same for shipped machines whose own differ.
const OWN_PARAMETER_SETS: [(&str, &str); 1] = [("hiab_xs031", "resources/real_hiab_xs031.ssv")];
/// Machines that are drawn where no number is asked for.
const SEEDS: u64 = 20;

/// Inertia scales of the ideal world, in the order of the paper's table.
pub const SCALES: [f64; 5] = [1.4, 1.2, 1.0, 0.8, 0.6];
/// Packed system of the bending world.
pub const BENDING_SYSTEM: &str = "Bending.ssd";
/// Largest communication step of the bending world, s: with 1 ms the exchange between an actuator
/// and the light end of a boom that bends rings by itself.
pub const BENDING_STEP: f64 = 5e-4;
/// Machines of the bending world that are drawn where no number is asked for: a run takes some ten
/// times as long as in the other worlds.
const BENDING_SEEDS: u64 = 5;
/// Largest error that the controller may leave in the bending world against the tip that its own
/// rigid kinematics tell, m.
pub const BENDING_TARGET: f64 = 2e-3;

/// A world.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum World {
    /// The controller's own model, all inertias by one factor: a check of the code
    Ideal,
    /// A machine that the controller does not know: actuators as built, sensors, a step of delay,
    /// errors drawn by seed
    Real,
    /// A structure that bends, in MuJoCo, its errors drawn by seed; steps of at most 0.5 ms
    Bending,
    /// As real, with motors, screws, friction, mounting, joints, wrist drives, load cells and clock
    /// drawn by seed
    StrictRigid,
    /// The structure that bends, with actuators as built and sensors, their parameters drawn by
    /// seed
    Strict,
}

impl World {
    /// Name on the command line.
    pub fn name(self) -> String {
        value_name(self)
    }

    /// Whether its plant bends, which MuJoCo in Python computes.
    pub fn bends(self) -> bool {
        matches!(self, Self::Bending | Self::Strict)
    }

    /// Whether its system is that of the real world.
    pub fn is_as_built(self) -> bool {
        matches!(self, Self::Real | Self::StrictRigid)
    }

    /// The trajectories on which laws are compared in it.
    pub fn trajectories(self) -> &'static [&'static str] {
        match self {
            Self::Ideal | Self::Real | Self::Bending => &TRAJECTORIES,
            Self::StrictRigid | Self::Strict => &ALL_TRAJECTORIES,
        }
    }

    /// Machines that are drawn where no number is asked for.
    pub fn usual_seeds(self) -> u64 {
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

/// The cases of a world: those of the ideal one are the inertia errors of the paper's table, those
/// of the others a machine for each seed, with errors up to `factor` times the usual bounds where
/// they are drawn here.
pub fn cases(world: World, system: &System, seeds: Range<u64>, factor: f64) -> Result<Cases> {
    let mut cases = match world {
        World::Ideal => by_scale(system)?.into(),
        World::Real | World::StrictRigid => {
            Cases::draw_machines(system, seeds, &Bounds::REAL.times(factor))?
        }
        World::Bending | World::Strict => by_seed_of_plant(system, seeds)?.into(),
    };
    if matches!(world, World::StrictRigid | World::Strict) {
        strict::harden(system, &mut cases.list, world.bends())?;
    }
    Ok(cases)
}

/// A case of the ideal world for each inertia scale.
fn by_scale(system: &System) -> Result<Vec<Case>> {
    let case = |scale: f64| {
        let label = format!("inertia {:+.0} %", 100.0 * (scale - 1.0));
        let setting = system.setting("inertia_scale", scale)?;
        Ok(Case::new(label, vec![setting]))
    };
    SCALES.into_iter().map(case).collect()
}

/// A case of the bending world for each seed.
fn by_seed_of_plant(system: &System, seeds: Range<u64>) -> Result<Vec<Case>> {
    let case = |seed| {
        let setting = system.setting("hdrm.seed", seed)?;
        Ok(Case::from_seed(seed, vec![setting]))
    };
    seeds.map(case).collect()
}

/// The parameter set of the machine `name`, or of one that extends it; of any other machine that of
/// the reference machine.
pub fn parameter_set_of(name: Option<&str>) -> &'static str {
    let own = OWN_PARAMETER_SETS.iter().find(|(of, _)| name == Some(*of));
    own.map_or(PARAMETERS, |(_, file)| file)
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
