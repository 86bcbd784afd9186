//! What the borders of all versions of FMI have in common: raw arguments of C functions, how a call gets in and out of an instance,
//! call order as a table, what the importer wants to hear, instantiation, and the parts of a model description that they share.

pub(crate) mod arguments;
pub(crate) mod body;
pub(crate) mod call;
pub(crate) mod description;
mod export;
pub(crate) mod files;
pub(crate) mod library;
pub(crate) mod log;
mod states;
