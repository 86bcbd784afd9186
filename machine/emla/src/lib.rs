//! The paper's model of the electromechanical linear actuator (EMLA): a permanent-magnet
//! synchronous motor drives a nut through a gear and a ball screw; the nut pushes a rod through a
//! spring and a damper. The FMU `Emla` wraps it; the controller predicts its measurements with it;
//! `motion-check` and the studies use its [`maps`], and the study `surrogate` trains its network.
//!
//! Source: section "Integrated Dynamic Model of the EMLA" of the paper; each function names its
//! equation and any departure from it. dq quantities are peak-valued, oriented to the rotor flux.
//! Rod position `x` and force `F` are positive when the actuator extends. SI units throughout.
//!
//! [`Emla`] is the configuration; [`State`] is passed by value, so a step that fails changes
//! nothing. There are two drive modes: in [`Drive::Motion`] the mechanism prescribes the rod's
//! motion and the actuator's force is the output; in [`Drive::Force`] the rod is a free mass under
//! an external force.
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

pub use actuator::{Emla, NoErrorBound};
pub use continuous::INDICATORS;
pub use machine_file::{ActuatorInput as Input, Dq, Drive};
pub use model_rules::StepError;
pub use options::Electric;
pub use output::Output;
pub use residual::UntrainedPoint;
pub use state::{Balance, LossKinds, Residual, State, Thermal};
pub use surrogate::{
    EfficiencyBound, LayerFile, MinMax, Ranges, Split, Surrogate, SurrogateError, SurrogateFile,
    SurrogateOutput, TrainingRecord, WIDTHS,
};

/// The example of the product's README.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct ReadMe;
