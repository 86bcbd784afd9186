//! An FMU as a caller sees it: opened, with its C functions and the order in which they may be
//! called, and instances of it with time and log, in either version of FMI. Whatever runs FMUs to
//! judge them stands on this.
#![allow(unsafe_code)] // loads a library, and calls it

pub mod calls;
#[cfg(feature = "native")]
mod derivatives;
#[cfg(feature = "native")]
mod fmu;
#[cfg(feature = "native")]
pub mod functions;
#[cfg(feature = "native")]
pub mod instance;
#[cfg(feature = "native")]
pub mod library;
#[cfg(feature = "native")]
mod log;
#[cfg(feature = "native")]
pub mod names;
#[cfg(feature = "native")]
pub mod order;
#[cfg(feature = "native")]
pub mod platform;
#[cfg(feature = "native")]
pub mod portability;
#[cfg(feature = "native")]
pub mod process;
pub mod standard;
#[cfg(feature = "native")]
mod states;
#[cfg(feature = "native")]
pub mod symbols;
#[cfg(feature = "native")]
pub mod text;
#[cfg(feature = "native")]
mod values;

pub use calls::{Callbacks, Functions3};
#[cfg(feature = "native")]
pub use {
    fmu::Fmu,
    instance::Instance,
    log::{Log, Message},
    states::SavedState,
};
