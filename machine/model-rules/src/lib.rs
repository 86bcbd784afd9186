//! Checks and messages that the models of this project share: parameters outside their range,
//! unusable step sizes, results that are not finite; and the number of substeps in a communication
//! step, which decides what step size is too long.
#![forbid(unsafe_code)]

mod parameter;
mod step;

pub use parameter::{ParamError, Range, check, check_each, require};
pub use step::{
    MAX_SUBSTEPS, RATE_STEP, RK4_STAGES, StepError, check_finite, check_step, substeps,
};
