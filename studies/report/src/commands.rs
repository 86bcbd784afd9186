//! The subcommands of `hdrm-fmu` that this program carries out.

pub mod drawings;
pub mod page;
