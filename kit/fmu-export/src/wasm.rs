//! What a WebAssembly module exports in addition to the C functions of FMI 3.0: for hosts of the
//! plain module [`memory`], [`files`] and [`callbacks`]; for hosts of a component [`component`].

mod answers;
mod callbacks;
#[doc(hidden)]
pub mod component;
mod exports;
mod files;
mod memory;
