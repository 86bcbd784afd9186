//! The analyses behind the subcommands: each makes a set of runs, measures them and judges the
//! result.

pub mod comparison;
pub(crate) mod draws;
pub mod efficiency;
pub(crate) mod endurance;
pub(crate) mod identification;
pub(crate) mod imported_run;
pub mod inertia;
pub mod margins;
pub mod robustness;
pub mod sizing;
pub mod stability;
pub mod surrogate_loop;
pub mod testbed;
pub(crate) mod tournament;
