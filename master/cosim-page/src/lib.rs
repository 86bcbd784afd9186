//! The engine of a page: a packed system or an FMU, and the run of it that goes on in the page.
//! [`border`] has the `unsafe` code of the master: functions that JavaScript calls by name, with
//! addresses in this module's memory, have no safe form.
//!
//! `worker.js` of `page-files` instantiates this crate's WebAssembly module, and is the host of the FMUs'
//! modules that `cosim` calls. Commands and answers are JSON ([`command`]), the values of a run are
//! an array ([`engine`]); [`border`] is what the worker sees. The crate compiles for other targets
//! so that its library can be used in tests; there FMUs are loaded as `cosim` does.
#![deny(unsafe_code)]

pub mod border;
pub mod command;
pub mod engine;
mod run;
