//! Measurements of a run, for this crate, the report and Python: tip, accuracy, energy, limits.

pub mod energy;
pub mod heat;
pub mod iso9283;
pub mod limits;
pub mod metrics;
pub mod power_integral;
pub mod run;
pub mod supply;
pub mod swinging;
pub mod tracking;
