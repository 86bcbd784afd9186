//! What derives add to a table, called as an importer calls it: by C name, through pointers.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

#[path = "../border/client.rs"]
#[allow(dead_code)] // an importer for several tests
mod client;
mod heater;
mod log;
mod rows;
#[path = "../border/states.rs"]
mod states;

/// The model that the importer loads.
mod probe {
    pub use crate::heater::Heater as Probe;
}
