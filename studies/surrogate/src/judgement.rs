//! Judges models on held-out profiles: their errors, with confidence intervals, for the commands.

pub mod candidates;
pub mod conformal;
pub mod free_run;
pub mod resampling;
