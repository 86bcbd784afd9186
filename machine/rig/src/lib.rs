//! The actuator as built: motor, drive, gear, screw and rod with what a controller's model of them
//! leaves out.
//!
//! It stands in the place of the idealised actuator with the same inputs and outputs, and shares
//! with it the undervoltage trip and the holding brake ([`machine_file::Holding`]); its equations are
//! its own, written from the books named at the functions. [`Extras`] says what it knows beyond
//! [`machine_file::Emla`]: saturation, temperature, ripple and cogging, an inverter that holds its
//! voltages in stator coordinates and acts late, stiction with presliding, backlash, compliance of
//! the mounting and torsion, larger losses, and heat. Each has a switch; with all of them off the
//! equations are those of the idealised actuator.
//!
//! The rod's position `x` and the force `F` are positive when the actuator extends. dq quantities
//! are peak-valued and oriented to the rotor flux. SI units throughout. [`Rig`] is the
//! configuration; [`State`] is passed by value, so a step that fails changes nothing.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // symbols of the books

mod conditions;
mod current_loop;
mod dynamics;
mod extras;
mod friction;
mod heat;
mod inverter;
mod link;
mod motor;
mod output;
mod rig;
mod start;
mod state;
mod step;
mod switching;

pub use current_loop::CurrentLoop;
pub use extras::{
    Backlash, Cogging, Compliance, Damping, Extras, Friction, Heat, Losses, Ripple, Saturation,
    Switching, Temperature,
};
pub use machine_file::{ActuatorInput as Input, Drive};
pub use model_rules::StepError;
pub use output::{Output, efficiency};
pub use rig::{Rig, RigError};
pub use state::{Balance, HeldVoltages, Powers, State};
