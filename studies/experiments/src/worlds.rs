//! The worlds in which control laws are compared (option `--world`) and their drawn machines, for
//! commands, report and Python. A world is a plant with sensors and errors unknown to control:
//!
//! - `ideal`: the plant is the controller's own model with all inertias scaled by one factor; this
//!   checks the code;
//! - `real`: actuators as built, sensors, one step of delay, and machine errors drawn by seed
//!   (module [`perturbation`]);
//! - `bending`: a structure that bends, simulated in MuJoCo, which draws its own errors by seed;
//! - `strict-rigid` and `strict`: the real world, and the bending structure with the actuators and
//!   sensors of the real world, both with more errors (module `strict`).

pub mod perturbation;
mod strict;
mod world;

pub use perturbation::{Bounds, Cases};
pub(crate) use world::value_name;
pub use world::{
    BENDING_STEP, BENDING_SYSTEM, BENDING_TARGET, MACHINE, PARAMETERS, SCALES, SYSTEM, World,
    cases, parameter_set_of, without_worlds,
};
