//! What a WebAssembly module of an FMU has beside the C functions of FMI 3.0, for hosts that give
//! it memory ([`memory`]), files ([`files`]) and callbacks ([`callbacks`]).

pub(crate) mod callbacks;
pub(crate) mod files;
mod memory;
