//! How models do on profiles that they have not seen, and how far their numbers can be trusted.

pub mod candidates;
pub mod conformal;
pub mod free_run;
pub mod resampling;
