//! Experiments on the coupled manipulator, made with the co-simulation master `cosim`: runs with their tip error ([`experiment`],
//! [`tip`]) and the machine's limits watched ([`watched`]), runs of other importers ([`elsewhere`]), the paper's table of inertia errors ([`table`]) and other errors ([`robustness`]), the one-axis experiment ([`testbed`]), the
//! stability proof in numbers ([`stability`]), the actuators' energy ([`energy`]) and efficiency ([`efficiency`]), a long run ([`endurance`]); and
//! the program's [`commands`].
//!
//! Everything is computed by the FMUs; names such as `tip_error_norm`, `settle_time` or `inertia_scale` are variables of theirs. The crate
//! `machine` serves the machine's limits and ratings, `hdrm` the check of machine files, `rig-data` and `emla` what a network predicts, `rig` the
//! control of a rig that loads another. What is drawn of all this is crate `report`.
#![forbid(unsafe_code)]

pub mod accuracy;
#[allow(
    missing_docs,
    reason = "what arguments are for is said to who calls the program"
)]
pub mod commands;
pub mod duty;
pub mod efficiency;
pub mod elsewhere;
pub mod endurance;
pub mod energy;
pub mod experiment;
pub mod laws;
pub mod loads;
pub mod machine_file;
pub mod machines;
pub mod metrics;
pub mod path_margins;
pub mod perturbation;
pub mod rig_testbed;
pub mod robustness;
pub mod signal_file;
pub mod sizing;
pub mod stability;
pub mod supply;
pub mod surrogate_loop;
pub mod table;
pub mod testbed;
pub mod tip;
pub mod tracking;
pub mod verdict;
pub mod watched;
pub mod worlds;
