//! An FMU of FMI 2.0 as a caller sees it: opened, with its C functions and the order in which they may be called.
#![allow(unsafe_code)] // loads a library

mod fmu;
pub mod functions;
mod log;
pub mod order;

pub use fmu::Fmu;
pub use log::{Log, Message};
