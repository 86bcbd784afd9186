//! Adaptive modular controller of the manipulator: closed-loop inverse kinematics, virtual
//! decomposition control with natural adaptation, and the low-level voltage law of each actuator.
//!
//! Source: the paper's section "Control"; labels in brackets are those of its equations, departures
//! are said where they are made. World frame: x forward, y up, z = x × y; SI throughout; dq
//! quantities peak-valued. The controller owns its nominal parameters: plant mismatch is one file
//! away.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

mod actuator_level;
mod adaptation;
mod clik;
mod controller;
mod decomposition;
mod error;
mod evaluation;
mod given_path;
mod integral;
mod load;
mod low_level;
mod prediction;
mod rates;
mod reference;
mod sampling;
mod signals;
mod speed;
mod stability;
mod trouble;

pub use controller::{Controller, tip_pose};
pub use error::ControllerError;
pub use evaluation::Evaluation;
pub use load::Load;
pub use rates::{Held, RateCommand, RateLimits};
pub use reference::{Desired, Trajectory};
pub use sampling::{DELAY_MAX, Timing};
pub use signals::{Derating, Input, Level, Mode, Output, Settings};
pub use stability::Conditions;
pub use trouble::{Told, Trouble};
