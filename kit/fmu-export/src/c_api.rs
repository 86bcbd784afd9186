//! What the borders of all versions of FMI have in common: raw arguments of C functions, how a call
//! gets in and out of an instance, call order, how a version lists its functions, what the importer
//! wants to hear, instantiation, and the parts of a model description that they share.

pub(crate) mod answer;
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
mod texts;
