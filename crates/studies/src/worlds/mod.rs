//! The worlds in which control laws are compared, and the machines that are drawn for them.
//!
//! - `ideal`: the plant is the controller's own model, all inertias scaled by one factor; a check
//!   of the code.
//! - `real`: actuators as built, sensors, one step of delay, and errors of the machine drawn by
//!   seed (module `real`);
//! - `bending`: a structure that bends, in MuJoCo, with errors that the plant draws itself by seed.

pub mod perturbation;
mod real;
mod world;

pub use real::{PARAMETERS, RealMachines, SYSTEM, parameters_of};
pub use world::{BENDING_STEP, BENDING_SYSTEM, BENDING_TARGET, Cases, SCALES, World, cases};
