//! FMI 2.0 for co-simulation over the core: C functions, elements as value references, statuses,
//! call order, messages to the importer's logger, and `modelDescription.xml`.

pub(crate) mod description;
pub mod entry;
pub mod ffi;
mod files;
mod instance;
mod instantiate;
mod log;
mod status;
mod uri;
