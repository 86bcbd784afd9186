//! Experiments on the coupled manipulator, made with the co-simulation master `cosim`: runs with their tip error ([`experiment`],
//! [`tip`]) and the machine's limits watched ([`watched`]), runs of other importers ([`elsewhere`]), the paper's table of inertia errors ([`table`]) and other errors ([`robustness`]), the one-axis experiment ([`testbed`]), the
//! stability proof in numbers ([`stability`]), the actuators' energy ([`energy`]) and efficiency ([`efficiency`]), a long run ([`endurance`]), and all of it as a page
//! ([`report`]).
//!
//! Everything is computed by the FMUs; names such as `tip_error_norm`, `settle_time` or `inertia_scale` are variables of theirs. The crate
//! `hdrm` serves the report's drawing only, `machine` that and the machine's limits and ratings, `surrogate` and `emla` what a network predicts and the command that trains one, `rig` the control of a rig that loads another.
#![forbid(unsafe_code)]

pub mod accuracy;
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
pub mod plot;
pub mod report;
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
