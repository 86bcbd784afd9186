//! The C interface of FMI 3.0, which `export_fmu!` exports to importers: functions, call order,
//! rows of the table as arrays with one value reference, statuses, logging, `modelDescription.xml`
//! and `terminalsAndIcons.xml`.

mod clocks;
mod dependencies;
pub(crate) mod description;
pub mod entry;
pub mod ffi;
pub(crate) mod instance;
mod instantiate;
mod log;
pub(crate) mod states;
mod values;
