//! Subcommands.

pub mod drawings;
pub mod page;
