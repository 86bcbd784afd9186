//! The part of the C interface that `fmi2` and `fmi3` share: C arguments, entering an instance,
//! call order, the list of a version's functions, logging, instantiation and model descriptions.
//! The modules `fmi2` and `fmi3` add what differs between the versions.

pub(crate) mod arguments;
pub(crate) mod call_order;
pub(crate) mod description;
pub(crate) mod export;
pub(crate) mod files;
pub(crate) mod fmi_instance;
pub(crate) mod functions;
pub(crate) mod library;
pub(crate) mod log;
mod saved_states;
pub mod status;
mod texts;
