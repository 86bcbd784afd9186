//! The paper's adaptive modular controller of the manipulator: closed-loop inverse kinematics,
//! virtual decomposition control (VDC) with natural adaptation, and the voltage law of each
//! actuator; also other control laws for comparison, operator commands, and a supervisor. The FMU
//! `Controller` wraps it.
//!
//! A [`Controller`] computes an [`Evaluation`] from measurements ([`Input`]); the commands
//! ([`Output`]) and the next state follow from it. The controller has its own nominal machine file,
//! so that a mismatch to the plant can be studied.
//!
//! Source: the paper's section "Control"; labels in brackets are those of its equations, and
//! departures are named. World frame: x forward, y up, z = x × y; SI; dq peak-valued.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

mod bodies;
mod conditions;
mod controller;
mod drive;
mod error;
mod evaluation;
mod laps;
mod law;
mod measured;
mod nominal;
mod proof;
mod reference;
mod settings;
mod signals;
mod state;
mod supervisor;
mod tracking;
mod warnings;

pub use conditions::Conditions;
pub use controller::Controller;
pub use error::ControllerError;
pub use evaluation::Evaluation;
pub use law::{MODES, Mode};
pub use measured::{DELAY_MAX, Timing};
pub use nominal::tip_pose;
pub use reference::{CommandHolds, RateCommand, RateLimits, Trajectory};
pub use settings::{Derating, Level, Settings};
pub use signals::{Input, Output};
pub use supervisor::{Cause, Stage};
pub use tip_path::Load;
pub use warnings::{ReportedWarnings, Warning};
