//! Co-simulation master for FMI 2.0 and 3.0, also mixed: runs a system of FMUs as its SSP system
//! structure describes it. The program `cosim`, pages, the studies and Python use it.
//!
//! The structure names the FMUs, their connections, the order in which they are stepped and the
//! power bonds ([`structure`]). The model descriptions declare which outputs depend directly on
//! which inputs ([`fmi_description`]). Both determine the order of the exchange ([`wiring`],
//! [`exchange`]). A loaded [`System`] finds variables by name once and returns a [`Port`] for each.
//! A [`Master`] initializes and steps the system; [`run`] steps it to a stop time and calls an
//! [observer](run::observer) at every communication point, such as [`Signals`], a [`Recording`] or
//! a log file. FMUs are loaded and called by [`fmi_import`], through [`fmu`] and [`instance`]; what
//! one call passes, elements or whole arrays, is planned before the run
//! ([`Batch`](fmi_import::batch::Batch)).
//!
//! Nothing here knows the physics.
//!
//! The feature `native` adds libraries and files, clocks and the command line. Without it, packages
//! are read from bytes, FMUs are WebAssembly modules of FMI 3.0 in the WebAssembly host that also
//! calls this library, and the caller makes the steps and supervises the run
//! ([`Supervision`](run::supervision::Supervision)).
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
pub use run::experiment::Experiment;
pub use run::recording::Recording;
pub use run::signals::{Inputs, Signals, matching};
pub use run::verdict::Verdict;
pub use structure::system::{Setting, System};
pub use wiring::Port;
