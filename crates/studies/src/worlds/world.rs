//! What is chosen by `--world`: the plant, and the cases that laws are compared on.

use std::ops::Range;

use anyhow::Result;
use clap::ValueEnum;
use cosim::system::System;
use serde::Serialize;

use super::real::{self, RealMachines};
use super::{bending, ideal};
use crate::grid::Case;

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
}

impl World {
    /// Name on the command line.
    pub fn name(self) -> String {
        let value = self.to_possible_value().expect("no value is skipped");
        value.get_name().to_owned()
    }

    /// Machines that are drawn where no number is asked for.
    pub fn usual_seeds(self) -> u64 {
        match self {
            Self::Bending => bending::SEEDS,
            Self::Ideal | Self::Real => real::SEEDS,
        }
    }
}

/// Cases, and the files that they name, which exist as long as this.
pub struct Cases {
    /// The cases.
    pub list: Vec<Case>,
    _machines: Option<RealMachines>,
}

/// The cases of a world: those of the ideal one are the inertia errors of the paper's table, those
/// of the others a machine for each seed.
pub fn cases(world: World, system: &System, seeds: Range<u64>) -> Result<Cases> {
    let (list, machines) = match world {
        World::Ideal => (ideal::cases(system)?, None),
        World::Real => {
            let mut machines = RealMachines::draw(system, seeds)?;
            (std::mem::take(&mut machines.cases), Some(machines))
        }
        World::Bending => (bending::cases(system, seeds)?, None),
    };
    Ok(Cases {
        list,
        _machines: machines,
    })
}
