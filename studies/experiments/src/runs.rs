//! Many runs: laws × cases × trajectories on all cores, runs that may be lost, and runs that are
//! kept on disk so that an interrupted analysis goes on where it was.

pub mod ended_run;
pub mod grid;
pub mod run_store;
