//! Experiments on the coupled manipulator, made with the co-simulation master `cosim`. A command
//! ([`commands`]) puts a run together on the [`mod@bench`]; a study ([`studies`]: the paper's
//! table, other errors, laws compared, testbed, stability proof, motors, a long run) makes a
//! [`grid`] of runs on the machines of a world ([`worlds`]) and takes measures of each
//! ([`measures`]: tip, tracking, accuracy, energy, limits); [`mod@print`] makes text, CSV and JSON
//! of what came out.
//!
//! Everything is computed by the FMUs; names such as `tip_error_norm`, `settle_time` or
//! `inertia_scale` are variables of theirs. The crate `machine` serves the machine's limits and
//! ratings, `hdrm` the check of machine files, `rig-data` and `emla` what a network predicts, `rig`
//! the control of a rig that loads another. What is drawn of all this is crate `report`.
#![forbid(unsafe_code)]

pub mod bench;
#[allow(
    missing_docs,
    reason = "what arguments are for is said to who calls the program"
)]
pub mod commands;
pub mod grid;
pub mod identification;
pub mod laws;
pub mod loads;
pub mod machine_choice;
pub mod machines;
pub mod measures;
pub mod path_margins;
pub mod print;
pub mod start_values;
pub mod studies;
pub mod trial;
pub mod worlds;
