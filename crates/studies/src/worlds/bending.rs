//! The world in which the structure bends: MuJoCo's dynamics of a machine whose errors the plant
//! draws itself by its seed.

use std::ops::Range;

use anyhow::Result;
use cosim::system::System;

use crate::grid::Case;

/// Packed system of the bending world.
pub const SYSTEM: &str = "Bending.ssd";
/// Largest communication step, s: with 1 ms the exchange between an actuator and the light end of a
/// boom that bends rings by itself.
pub const STEP: f64 = 5e-4;
/// Machines that are drawn where no number is asked for: a run takes some ten times as long as in
/// the other worlds.
pub const SEEDS: u64 = 5;
/// Largest error that the controller may leave against the tip that its own rigid kinematics tell,
/// m.
pub const TARGET: f64 = 2e-3;

/// One case for each seed.
pub fn cases(system: &System, seeds: Range<u64>) -> Result<Vec<Case>> {
    let case = |seed| {
        let setting = system.setting("hdrm.seed", seed)?;
        Ok(Case::of_seed(seed, vec![setting]))
    };
    seeds.map(case).collect()
}
