//! What an FMU does when it is run. Each promise is tried in a process of its own, so that a crash,
//! a hang or a word on standard output is a row of the table.

mod calls;
mod derivatives;
mod exchange;
mod fmi3_only;
mod instances;
mod misuse;
mod simulation;
mod states;
mod supervision;
mod trial;
mod values;

pub use supervision::{all, one};
