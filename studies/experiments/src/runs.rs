//! Many runs, for the analyses and the report: laws × cases × trajectories on all cores ([`grid`]),
//! runs in which the tip may leave its reference ([`ended_run`]), and runs kept on disk, so that an
//! interrupted analysis can continue ([`run_store`]). One run may be recorded as MCAP.

pub mod ended_run;
pub mod grid;
#[cfg(feature = "commands")]
pub mod mcap;
pub mod run_store;
