//! One question a file: which runs it takes, what they are worth.

pub mod comparison;
pub mod draws;
pub mod efficiency;
pub mod endurance;
pub mod identification;
pub mod imported_run;
pub mod inertia;
pub mod margins;
pub mod robustness;
pub mod sizing;
pub mod stability;
pub mod surrogate_loop;
pub mod testbed;
pub mod tournament;
