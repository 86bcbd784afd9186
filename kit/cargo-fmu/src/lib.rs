//! FMUs from libraries made with `fmu-export`: building them, reading the files they carry, and
//! packing both into archives.
//!
//! The program is `cargo fmu` (see [`pack`]); other tools use its parts from here. No model is
//! linked: libraries are loaded, asked for their files, and closed again.
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
