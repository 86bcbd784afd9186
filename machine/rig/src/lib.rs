//! A detailed model of the electromechanical linear actuator ("as built"), to test controllers that
//! only know the idealised model `emla`. The FMU `Rig` and the studies' virtual test rigs use it.
//!
//! The effects beyond the idealised actuator are in [`Extras`]: saturation, temperature, ripple and
//! cogging, an inverter that samples and delays its voltages, stiction with presliding, backlash,
//! compliance of mounting and torsion, larger losses, and heat. Each has a switch; with all off the
//! equations are those of the idealised actuator. They are implemented independently of `emla`,
//! from the books named at the functions; only the undervoltage trip and the holding brake
//! ([`machine_file::BrakeState`]) are shared.
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
