//! Experiments on the coupled manipulator, made with the co-simulation master `cosim`.
//!
//! A command ([`commands`]) sets a run up ([`setup`]: system, world, machine file, path, start
//! values); an analysis ([`analyses`]: the paper's table, other errors, laws compared, testbed,
//! stability proof, motors, a long run) makes many such runs ([`runs`]) on the machines of a world
//! ([`worlds`]) and takes measures of each ([`measures`]: tip, tracking, accuracy, energy, limits);
//! [`mod@print`] makes text, CSV and JSON of what came out. [`machines`] is what can be told of a
//! machine without a run: other sizes, lasting torques, margins along a path.
//!
//! Everything is computed by the FMUs; names such as `tip_error_norm`, `settle_time` or
//! `inertia_scale` are variables of theirs. The crate `machine-file` serves the machine's limits
//! and ratings, `hdrm` the check of machine files, `surrogate` and `emla` what a network predicts,
//! `rig` the control of a rig that loads another. What is drawn of all this is crate `report`.
#![forbid(unsafe_code)]

pub mod analyses;
#[allow(
    missing_docs,
    reason = "what arguments are for is said to who calls the program"
)]
pub mod commands;
pub mod machines;
pub mod measures;
pub mod print;
pub mod runs;
pub mod setup;
pub mod worlds;
