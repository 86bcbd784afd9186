//! Why a call did not succeed.

use crate::ModelError;

/// Every failure leaves the instance as it was before the call.
#[derive(Debug)]
pub(crate) enum Failure {
    /// fmi2Error: the call was wrong, or the model refused it.
    Error(String),
    /// fmi2Discard: the step, or the inquiry, could not be done.
    Discard(String),
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Failure::Error(error.to_string())
    }
}

/// `Err(Failure::Error(format!(…)))`.
macro_rules! refuse {
    ($($text:tt)*) => { Err($crate::failure::Failure::Error(format!($($text)*))) };
}
pub(crate) use refuse;
