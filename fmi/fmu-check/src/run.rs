//! What an FMU does when run, for `fmu_check::check`. A [probe](probe::Probe) tests each promise in
//! its own process, so a crash, a hang or a line on standard output becomes a row of the report.

mod calls;
mod dependence;
mod derivatives;
mod exchange;
mod fmi3_only;
mod instances;
mod misuse;
mod probe;
mod simulation;
mod states;
mod supervision;
mod values;

pub use supervision::{all, one};
