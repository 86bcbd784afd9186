//! Makes FMUs of Rust models that use `fmu-export`: builds their libraries, gets the files that
//! these carry, and packs both into archives.
//!
//! This is the library of the program `cargo fmu`, for tools that do the same. No model is linked:
//! libraries are loaded, asked for their files, and closed again.
#![forbid(unsafe_code)]

pub mod library;
pub mod licences;
pub mod new;
pub mod notices;
pub mod pack;
pub mod process;
pub mod target;
#[cfg(feature = "wasm")]
pub mod wasm;
#[cfg(feature = "wasm")]
pub mod web;
pub mod workspace;
