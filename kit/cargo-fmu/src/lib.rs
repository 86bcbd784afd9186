//! Makes FMUs of Rust models that use `fmu-export`: builds their libraries, gets the files that
//! these carry, and packs both into archives, for the program `cargo fmu`, and for `xtask`, which
//! builds and tests this project with it. No model is linked: libraries are loaded, asked for their
//! files, and closed again.
#![forbid(unsafe_code)]

pub mod library;
pub mod licences;
pub mod new;
pub mod notices;
pub mod pack;
pub mod process;
pub mod reference;
pub mod target;
#[cfg(feature = "check")]
pub mod verify;
#[cfg(feature = "wasm")]
pub mod wasm;
#[cfg(feature = "wasm")]
pub mod web;
pub mod workspace;
