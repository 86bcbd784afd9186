//! From a profile to rows of data, for this crate, `report` and `experiments`: motions and loads,
//! the rig driven along them, means over 20 ms of measured and true values, files of the rows.

pub mod campaign;
pub mod coupled_run;
pub mod data;
pub mod drive_control;
pub mod profile;
pub mod rig_run;
pub mod signal_file;
pub mod windows;
