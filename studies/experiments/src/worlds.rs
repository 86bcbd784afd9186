//! The worlds in which control laws are compared, and the machines that are drawn for them.
//!
//! - `ideal`: the plant is the controller's own model, all inertias scaled by one factor; a check
//!   of the code.
//! - `real`: actuators as built, sensors, one step of delay, and errors of the machine drawn by
//!   seed (module [`perturbation`]);
//! - `bending`: a structure that bends, in MuJoCo, with errors that the plant draws itself by seed;
//! - `strict-rigid` and `strict`: the real world, and the structure that bends under its actuators
//!   and sensors, with more that is drawn (module `strict`).

pub mod perturbation;
mod strict;
mod world;

pub use perturbation::{Bounds, Cases};
pub use strict::SYSTEM as STRICT_SYSTEM;
pub(crate) use world::value_name;
pub use world::{
    BENDING_STEP, BENDING_SYSTEM, BENDING_TARGET, PARAMETERS, SCALES, SYSTEM, World, cases,
    parameter_set_of,
};
