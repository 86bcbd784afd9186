//! A run from its conditions to its verdict: instances made, stepped to a stop time, watched, and
//! what came out of it.

pub mod divergence;
pub mod experiment;
pub mod forgotten;
pub(crate) mod instances;
pub mod observer;
#[cfg(feature = "native")]
mod plan;
pub mod recording;
pub mod signals;
#[cfg(feature = "native")]
pub mod simulate;
pub mod snapshot;
pub mod spare;
pub mod supervision;
#[cfg(feature = "native")]
pub(crate) mod trial;
pub mod verdict;
