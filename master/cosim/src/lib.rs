//! Co-simulation master for FMI 2.0 and 3.0, also mixed: runs a system of FMUs as its SSP
//! system structure describes it.
//!
//! The structure says which FMUs there are, who is wired to whom, in which order they are stepped
//! and which connections are power bonds ([`structure`]); the model descriptions say which outputs
//! depend directly on which inputs ([`fmi_description`]); both give the order of the exchange
//! ([`wiring`], [`exchange`]). A loaded [`system`] finds variables by name once and hands out
//! [`wiring::Port`]s for them. [`master`] initializes and steps; [`run`] steps to a stop time and
//! lets the caller observe every communication point, for example through an [`observer`]:
//! [`signals`], a [`recording`], a file. FMUs are loaded and called by [`fmi_import`], by way of [`fmu`]
//! and [`instance`]; what one call passes, elements or whole arrays, is planned before the run
//! ([`Batch`](fmi_import::batch::Batch)).
//!
//! Nothing here knows the physics.
//!
//! Without the feature `native` there are no libraries and files of a system, no clock and no
//! command line: packages are read from bytes, FMUs are WebAssembly modules of FMI 3.0 that a host
//! of WebAssembly calls, and the caller makes the steps and has them watched ([`supervision`]).
#![forbid(unsafe_code)]

#[cfg(feature = "native")]
pub mod cli;
pub mod describe;
pub mod exchange;
pub mod fmu;
pub mod instance;
pub mod io;
pub mod master;
pub mod run;
pub mod schedule;
pub mod stepping;
pub mod structure;
pub mod wiring;

pub use master::{Master, instantiate, start_value};
pub use run::recording::Recording;
pub use run::signals::{Inputs, Signals, matching};
#[cfg(feature = "native")]
pub use run::simulate::Experiment;
pub use run::verdict::Verdict;
pub use structure::system::{Setting, System};
pub use wiring::Port;
