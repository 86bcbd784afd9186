//! An FMU as a caller sees it: opened, with its C functions and the order in which they may be called, in either version of FMI.
#![allow(unsafe_code)] // loads a library

mod fmi2;
pub mod fmi3;
mod fmu;
pub mod functions;
mod log;
pub mod names;
pub mod order;
mod values;

pub use fmi2::Functions as Functions2;
pub use fmu::Fmu;
pub use log::{Log, Message};
