//! The C interface of FMI 3.0: its functions and their call order, rows of the table as arrays with
//! one value reference, statuses, messages to the importer's logger, `modelDescription.xml` and
//! `terminalsAndIcons.xml`.

mod dependencies;
pub(crate) mod description;
pub mod entry;
pub mod ffi;
mod files;
pub(crate) mod instance;
mod instantiate;
mod log;
pub(crate) mod states;
mod unsupported;
mod values;
