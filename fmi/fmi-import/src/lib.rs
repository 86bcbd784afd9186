//! Imports FMUs of FMI 2.0 and 3.0: opens them, makes instances, and calls their functions, for the
//! master `cosim`, for `fmu-check` and for `torture`; `cargo fmu` inspects libraries with it.
//!
//! [`Fmu`] is an FMU whose library is loaded. There are three kinds of instances of it:
//!
//! - [`RawInstance`](raw::RawInstance): the C functions of either version, called with slices, in
//!   any order and with NULL where that is wanted. All others are built on it.
//! - [`Instance`]: calls in the order of the standard, with time, log and saved states; for
//!   programs that test FMUs.
//! - [`FmiInstance`](fmi_instance::FmiInstance) (feature `master`): the interface of a
//!   co-simulation master to an instance in a library, in a page's WebAssembly module or in another
//!   thread.
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
//! An FMU is foreign code with all rights of this process: open only FMUs that you trust. This
//! crate ensures that all it passes to an FMU is valid for as long as the FMU may use it.
#![cfg_attr(all(doctest, feature = "native"), doc = include_str!("../README.md"))]
#![allow(unsafe_code)] // loads libraries, and calls them

#[cfg(feature = "master")]
pub mod answer;
#[cfg(feature = "master")]
pub mod batch;
mod calls;
#[cfg(feature = "master")]
mod clocks;
pub mod digits;
mod encoding;
#[cfg(feature = "master")]
mod exchange;
#[cfg(feature = "native")]
mod exported;
#[cfg(all(feature = "master", feature = "native"))]
mod fmi2;
#[cfg(feature = "master")]
mod fmi3;
#[cfg(feature = "master")]
pub mod fmi_instance;
mod fmu;
mod functions;
#[cfg(feature = "native")]
pub mod instance;
#[cfg(feature = "master")]
mod instantiate;
#[cfg(all(feature = "master", feature = "native", target_os = "linux"))]
pub mod isolated;
#[cfg(feature = "native")]
mod library;
mod limits;
pub mod log;
pub mod messages;
#[cfg(not(feature = "native"))]
mod module;
mod names;
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
mod text;
pub mod under_way;
pub mod value;
#[cfg(feature = "native")]
mod values;

#[cfg(feature = "master")]
pub use clocks::{ClockPlan, is_triggered};
#[cfg(feature = "master")]
pub use exchange::{ExchangePlan, as_component};
#[cfg(feature = "native")]
pub use exported::{UnsupportedType, exported_files};
pub use fmu::Fmu;
#[cfg(feature = "master")]
pub use fmu_solver::Choice;
pub use functions::Functions;
#[cfg(feature = "native")]
pub use instance::Instance;
#[cfg(feature = "master")]
pub use instantiate::instantiate;
pub use limits::Limits;
pub use names::with_fmi3_names;
