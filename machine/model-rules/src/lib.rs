//! What a model refuses: parameters outside their range, steps that cannot be taken, results that
//! are not finite. Also how many substeps a communication step is divided into, because that
//! decides which steps are too long.
//!
//! Every model has its own parameters, state and equations; these rules and the words of their
//! messages are the same for all.
#![forbid(unsafe_code)]

mod parameter;
mod step;

pub use parameter::{ParamError, Range, check, check_each, require};
pub use step::{
    MAX_SUBSTEPS, RATE_STEP, RK4_STAGES, StepError, check_finite, check_step, substeps,
};
