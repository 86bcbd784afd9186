//! From a profile to rows of data: motions and loads, the rig that is driven along them, means over
//! 20 ms of its sensors' readings and of the true values, and the files of rows and signals.

pub mod campaign;
pub mod coupled_run;
pub mod data;
pub mod drive_control;
pub mod profile;
pub mod rig_run;
pub mod signal_file;
pub mod windows;
