//! Subcommands.

pub mod figures;
pub mod machine;
pub mod page;
pub mod plot;
