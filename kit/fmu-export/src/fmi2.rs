//! The C interface of FMI 2.0, which `export_fmu!` exports to importers: functions, call order, one
//! value reference per scalar element, statuses, logging and `modelDescription.xml`.

pub(crate) mod description;
pub mod entry;
pub mod ffi;
mod instance;
mod instantiate;
mod log;
mod uri;
