//! The variables that the FMUs `Emla` and `Rig` have in common, so that a system can exchange one
//! for the other without other wiring: inputs, the parameters of the machine file's section `emla`,
//! enumerations, terminals and resources. All shells with a machine file read it by [`machine`].
//!
//! The rows are macros, because each refers to fields of the FMU's own types: its inputs must be
//! [`Input`], and its parameters must have the fields that [`actuator_parameters!`] names.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

mod info;
mod input;
mod rows;

pub use info::{
    AXIS, DRIVE, REFERENCE, RESOURCES, ROOM_TEMPERATURE, TERMINALS, UNITS, X_LARGEST, X_START,
    machine, own_machine, own_name, read_machine,
};
pub use input::{Input, rod_end};
pub use rows::energy;
