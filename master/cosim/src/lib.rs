//! Co-simulation master for FMI 2.0 and 3.0, also mixed: runs a system of FMUs as its SSP
//! system structure describes it.
//!
//! The structure says which FMUs there are, who is wired to whom, in which order they are stepped
//! and which connections are power bonds ([`structure`]); the model descriptions say which outputs
//! depend directly on which inputs ([`fmu_description`]); both give the order of the exchange
//! ([`wiring`], [`exchange`]). A loaded [`system`] finds variables by name once and hands out
//! [`wiring::Port`]s for them. [`master`] initializes and steps; [`run`] steps to a stop time and
//! lets the caller observe every communication point, for example through an [`observer`]:
//! [`signals`], a [`recording`], a file. FMUs are unpacked and called by [`fmu`] and [`slave`];
//! what one call passes, elements or whole arrays, is planned before the run ([`batch`]).
//!
//! Nothing here knows the physics.
//!
//! Without the feature `native` there are no libraries and files of a system, no clock and no
//! command line: packages are read from bytes, FMUs are WebAssembly modules of FMI 3.0 that a host
//! of WebAssembly calls, and the caller makes the steps and has them watched ([`supervision`]).
#![deny(unsafe_code)]

mod algebraic_loop;
mod arrays;
mod balance;
pub mod batch;
pub mod bond;
pub mod cells;
#[cfg(feature = "native")]
pub mod cli;
mod coupling;
pub mod crew;
#[cfg(feature = "native")]
pub mod csv;
pub mod describe;
pub mod divergence;
pub mod exchange;
pub mod experiment;
pub mod faults;
pub mod fmu;
pub mod forgotten;
pub mod input_table;
mod instances;
pub mod master;
mod means;
pub mod numbers;
pub mod observer;
pub mod output;
pub mod package;
pub mod probing;
pub mod recording;
mod renaming;
#[cfg(feature = "native")]
pub mod run;
pub mod scenario;
pub mod schedule;
pub mod signals;
pub mod slave;
pub mod snapshot;
pub mod spare;
pub mod stepping;
pub mod structure;
pub mod supervision;
pub mod system;
pub mod transformation;
#[cfg(feature = "native")]
mod trial;
pub mod units;
pub mod value;
pub mod verdict;
pub mod wiring;

pub use master::{Master, instantiate, start_value};
pub use recording::Recording;
#[cfg(feature = "native")]
pub use run::Experiment;
pub use signals::{Inputs, Signals, matching};
pub use system::{Setting, System};
pub use verdict::Verdict;
pub use wiring::Port;
