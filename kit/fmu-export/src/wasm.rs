//! What a WebAssembly module of an FMU has beside the C functions of FMI 3.0: for hosts of the plain
//! module [`memory`], [`files`] and [`callbacks`], for those of a component [`component`].

mod answers;
mod callbacks;
#[doc(hidden)]
pub mod component;
mod files;
mod memory;
