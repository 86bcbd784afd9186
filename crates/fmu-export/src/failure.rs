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

impl Failure {
    /// fmi2Error with a message; out of line, so that the checks of the hot path stay short.
    #[cold]
    #[inline(never)]
    pub(crate) fn error(message: std::fmt::Arguments<'_>) -> Self {
        Failure::Error(message.to_string())
    }
}

/// `Err` of fmi2Error with a formatted message.
macro_rules! refuse {
    ($($text:tt)*) => { Err($crate::failure::Failure::error(format_args!($($text)*))) };
}
pub(crate) use refuse;
