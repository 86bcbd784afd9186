//! A run of a system, for programs, Python and pages: instances are made and initialized, stepped
//! to a stop time and observed; the outcome ends with a verdict on the result.

pub(crate) mod alarms;
pub mod divergence;
pub mod experiment;
pub mod instance_cache;
pub(crate) mod instances;
#[cfg(feature = "native")]
pub mod interrupt;
pub mod observer;
#[cfg(feature = "native")]
mod plan;
pub mod recording;
pub mod run_key;
pub mod signals;
#[cfg(feature = "native")]
pub mod simulate;
pub mod snapshot;
pub mod structure_gaps;
pub mod supervision;
#[cfg(feature = "native")]
mod thread_choice;
pub mod verdict;
