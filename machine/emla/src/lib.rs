//! Electromechanical linear actuator: a permanent-magnet synchronous motor drives a nut over a gear
//! and a ball screw; the nut pushes a rod through a spring and a damper.
//!
//! Source: section "Integrated Dynamic Model of the EMLA" of the paper; its equation labels stand
//! at the functions, and so does each departure from it. Quantities in dq coordinates are
//! peak-valued and oriented to the rotor flux. The rod's position `x` and its force `F` are
//! positive when the actuator extends. SI units throughout.
//!
//! [`Emla`] is the configuration, immutable after [`Emla::new`]; [`State`] is what changes and is
//! passed by value, so a step that fails leaves everything as it was. Two drive modes:
//! in [`Drive::Motion`] the mechanism prescribes the rod's motion and the actuator answers with its
//! force; in [`Drive::Force`] the rod is a free mass with an external force on it.
//!
//! The maps in [`maps`] need only parameters; the controller calls them with its own nominal set.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

mod actuator;
mod conditions;
mod continuous;
mod dynamics;
mod efficiency;
mod heat;
mod instant;
mod losses;
pub mod maps;
mod motor;
mod options;
mod output;
mod residual;
mod start;
mod state;
mod step;
mod substep;
mod surrogate;
mod switching;
mod tangent;
mod tanh;

pub use actuator::{Emla, Unbounded};
pub use continuous::INDICATORS;
pub use machine_file::{ActuatorInput as Input, Dq, Drive};
pub use model_rules::StepError;
pub use options::Electric;
pub use output::Output;
pub use residual::Untrained;
pub use state::{Balance, LossKinds, Residual, State, Thermal};
pub use surrogate::{
    EfficiencyBound, LayerFile, MinMax, Ranges, Split, Surrogate, SurrogateError, SurrogateFile,
    SurrogateOutput, TrainingRecord, WIDTHS,
};

/// The example of the product's README.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct ReadMe;
