//! The co-simulation master as a WebAssembly module: it opens a packed system or an FMU and runs it
//! in a web page. `cargo fmu web` puts the module into the pages that it makes.
//!
//! `worker.js` of `page-files` instantiates this module and hosts the WebAssembly modules of the
//! FMUs, which `cosim` calls. Commands and answers are JSON ([`command`]); the values of a run are
//! an array ([`engine`]). [`exports`] are the functions that the worker calls by name, with
//! addresses in this module's memory, which needs `unsafe`. The crate compiles for other targets so
//! that tests can use it; there FMUs are loaded as by `cosim`.
#![deny(unsafe_code)]

pub mod command;
pub mod engine;
pub mod exports;
mod run;
