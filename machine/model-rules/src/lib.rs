//! Checks and messages that the models `hdrm`, `emla`, `rig` and `dclink` share: parameters outside
//! their range (also for `tip-path`), unusable step sizes, results that are not finite; and the
//! number of substeps in a communication step, which decides what step size is too long.
#![forbid(unsafe_code)]

mod parameter;
mod step;

pub use parameter::{ParamError, Range, check, check_each, require};
pub use step::{
    MAX_SUBSTEPS, RATE_STEP, RK4_STAGES, Seconds, StepError, check_finite, check_step, substeps,
};
