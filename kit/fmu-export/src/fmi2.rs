//! The C interface of FMI 2.0: its functions and their call order, one value reference per scalar
//! element, statuses, messages to the importer's logger, and `modelDescription.xml`.

pub(crate) mod description;
pub mod entry;
pub mod ffi;
mod files;
mod instance;
mod instantiate;
mod log;
mod status;
mod uri;
