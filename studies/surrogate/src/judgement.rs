//! Judges models on held-out profiles, for commands; its intervals are also for `experiments`.

pub mod candidates;
pub mod conformal;
pub mod free_run;
pub mod resampling;
