//! What is chosen by `--world`: the plant, and the cases that laws are compared on.

use std::ops::Range;

use anyhow::Result;
use clap::ValueEnum;
use cosim::system::System;
use serde::Serialize;

use super::perturbation::Bounds;
use super::real::{self, DrawnMachines};
use super::{bending, ideal, strict};
use crate::grid::{ALL_TRAJECTORIES, Case, TRAJECTORIES};

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
        let value = self.to_possible_value().expect("no value is skipped");
        value.get_name().to_owned()
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
            Self::Bending | Self::Strict => bending::SEEDS,
            Self::Ideal | Self::Real | Self::StrictRigid => real::SEEDS,
        }
    }
}

/// Cases, and the files that they name, which exist as long as this.
pub struct Cases {
    /// The cases.
    pub list: Vec<Case>,
    _machines: Option<DrawnMachines>,
}

/// The cases of a world: those of the ideal one are the inertia errors of the paper's table, those
/// of the others a machine for each seed.
pub fn cases(world: World, system: &System, seeds: Range<u64>) -> Result<Cases> {
    let (list, machines) = match world {
        World::Ideal => (ideal::cases(system)?, None),
        World::Real | World::StrictRigid => {
            let mut machines = DrawnMachines::draw(system, seeds, &Bounds::REAL)?;
            let mut cases = std::mem::take(&mut machines.cases);
            if world == World::StrictRigid {
                strict::harden(system, &mut cases, false)?;
            }
            (cases, Some(machines))
        }
        World::Bending => (bending::cases(system, seeds)?, None),
        World::Strict => {
            let mut cases = bending::cases(system, seeds)?;
            strict::harden(system, &mut cases, true)?;
            (cases, None)
        }
    };
    Ok(Cases {
        list,
        _machines: machines,
    })
}
