//! What the FMUs of an actuator have in common, so that one takes the place of another by the
//! wiring alone: the inputs, the parameters of the machine's section `emla`, enumerations,
//! terminals and resources.
//!
//! Rows are macros, because the model's own inputs and parameters are behind their fields: a
//! model's inputs are [`Input`], and its parameters have the fields that [`actuator_parameters!`]
//! names.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

mod info;
mod input;
mod rows;

pub use info::{
    AXIS, DRIVE, RESOURCES, ROOM_TEMPERATURE, TERMINALS, UNITS, X_LARGEST, X_START, read_machine,
};
pub use input::{Input, rod_end};
pub use rows::energy;
