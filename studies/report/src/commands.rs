//! The subcommands of `hdrm-fmu` that this program carries out; `main` calls them.

pub mod drawings;
pub mod page;
