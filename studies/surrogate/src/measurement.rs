//! From a profile to rows: motions and loads, the rig that is driven along them, means over 20 ms of
//! what its sensors say and of what is true, and the files that rows and signals are kept in.

pub mod campaign;
pub mod coupled_run;
pub mod data;
pub mod drive_control;
pub mod profile;
pub mod rig_run;
pub mod signal_file;
pub mod windows;
