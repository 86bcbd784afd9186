//! Imports FMUs of FMI 2.0 and 3.0: opens them, makes instances, and calls them, in the order of the
//! standard or out of it. Whoever runs FMUs, to simulate or to judge them, comes here for that.
//!
//! [`Fmu`] is an FMU with its library loaded. What is made of it comes in three layers:
//!
//! - [`RawInstance`](raw::RawInstance): the C functions of either version, called with slices. Any
//!   call in any order, also with NULL: for whoever tries what an FMU bears.
//! - [`Instance`]: an importer that follows the standard, with time, log and saved states.
//! - [`FmiInstance`](fmi_instance::FmiInstance) (feature `master`): what a co-simulation master asks
//!   of an instance, wherever it is: in a library, a page's WebAssembly module, another thread.
//!
//! The functions themselves, and the states in which each may be called, are tables in
//! [`standard`].
//!
//! ```
//! use fmi_import::standard::{Function, Mode};
//!
//! let step = Function::named("fmi2DoStep").unwrap();
//! assert!(step.is_allowed(Mode::Stepping) && !step.is_allowed(Mode::Instantiated));
//! ```
//!
//! An FMU is foreign code with all rights of this process, so to open one is to trust it. What is
//! safe here is what we pass: it is valid for as long and as far as the FMU may look at it.
#![cfg_attr(all(doctest, feature = "native"), doc = include_str!("../README.md"))]
#![allow(unsafe_code)] // loads libraries, and calls them

#[cfg(feature = "master")]
pub mod answer;
#[cfg(feature = "master")]
pub mod batch;
pub mod calls;
#[cfg(feature = "master")]
pub mod clocks;
#[cfg(feature = "native")]
mod derivatives;
mod encoding;
#[cfg(feature = "native")]
pub mod exported;
#[cfg(all(feature = "master", feature = "native"))]
mod fmi2;
#[cfg(feature = "master")]
mod fmi3;
#[cfg(feature = "master")]
pub mod fmi_instance;
mod fmu;
pub mod functions;
#[cfg(feature = "native")]
pub mod instance;
#[cfg(feature = "master")]
mod instantiate;
#[cfg(feature = "native")]
pub mod library;
pub mod log;
pub mod messages;
#[cfg(not(feature = "native"))]
mod module;
pub mod names;
pub mod output;
#[cfg(feature = "native")]
pub mod platform;
#[cfg(feature = "native")]
pub mod portability;
#[cfg(feature = "native")]
pub mod process;
pub mod raw;
#[cfg(feature = "master")]
mod saved;
pub mod standard;
#[cfg(feature = "native")]
mod states;
pub mod status;
pub mod text;
pub mod value;
#[cfg(feature = "native")]
mod values;

pub use fmu::Fmu;
#[cfg(feature = "native")]
pub use instance::Instance;
#[cfg(feature = "master")]
pub use instantiate::instantiate;
