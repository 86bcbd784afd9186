//! The worlds in which control laws are compared, and the machines that are drawn for them.
//!
//! - `ideal`: the plant is the controller's own model, all inertias scaled by one factor; a check
//!   of the code.
//! - `real`: actuators as built, sensors, one step of delay, and errors of the machine drawn by
//!   seed (module `real`);
//! - `bending`: a structure that bends, in MuJoCo, with errors drawn by seed (module `bending`);
//! - `strict-rigid` and `strict`: the real world, and the structure that bends under its actuators
//!   and sensors, with more that is drawn (module `strict`).

mod bending;
mod ideal;
pub mod perturbation;
mod real;
mod strict;
mod world;

pub use bending::{STEP as BENDING_STEP, SYSTEM as BENDING_SYSTEM, TARGET as BENDING_TARGET};
pub use ideal::SCALES;
pub use perturbation::Bounds;
pub use real::{DrawnMachines, PARAMETERS, SYSTEM, parameters_of};
pub use strict::SYSTEM as STRICT_SYSTEM;
pub use world::{Cases, World, cases};
