//! An FMU as a caller sees it: opened, with its C functions and the order in which they may be
//! called, and instances of it with time and log, in either version of FMI. Whatever runs FMUs to
//! judge them stands on this.
#![allow(unsafe_code)] // loads a library, and calls it

mod derivatives;
mod fmu;
pub mod functions;
pub mod instance;
mod log;
pub mod names;
pub mod order;
mod states;
pub mod symbols;
pub mod text;
mod values;

pub use fmu::Fmu;
pub use fmu_description::calls::{Callbacks, Functions3};
pub use instance::Instance;
pub use log::{Log, Message};
pub use states::SavedState;
