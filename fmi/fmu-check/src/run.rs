//! What an FMU does when run, for `check`. Each promise is tested by a [probe](probe::Probe) in its
//! own process, so that a crash, a hang or a line on standard output becomes a row of the report.

mod calls;
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
