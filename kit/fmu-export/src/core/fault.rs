//! Why a call did not succeed.

use super::error::ModelError;

/// Every fault leaves the instance as it was before the call.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The call was wrong, or the model refused it.
    Refused(String),
    /// A value out of its bounds, a step that cannot be done, an inquiry without an answer: another
    /// one may succeed.
    Discarded(String),
    /// No element has this number.
    Unknown(u32),
}

impl From<ModelError> for Fault {
    fn from(error: ModelError) -> Self {
        Fault::Refused(error.to_string())
    }
}

impl Fault {
    /// A refusal with a message; out of line, so that the checks of the hot path stay short.
    #[cold]
    #[inline(never)]
    pub(crate) fn refused(message: std::fmt::Arguments<'_>) -> Self {
        Fault::Refused(message.to_string())
    }

    /// Like [`refused`](Self::refused), for a value or a step.
    #[cold]
    #[inline(never)]
    pub(crate) fn discarded(message: std::fmt::Arguments<'_>) -> Self {
        Fault::Discarded(message.to_string())
    }
}

/// `Err` of a refusal with a formatted message.
macro_rules! refuse {
    ($($text:tt)*) => { Err($crate::core::fault::Fault::refused(format_args!($($text)*))) };
}
pub(crate) use refuse;

/// `Err` of a value, step or inquiry that is discarded, with a formatted message.
macro_rules! discard {
    ($($text:tt)*) => { Err($crate::core::fault::Fault::discarded(format_args!($($text)*))) };
}
pub(crate) use discard;

/// What values are counted by that are given for variables.
pub(crate) const OF_VARIABLES: &str = "elements of these variables";

/// Refuses a number of values that is not the one there is.
#[inline]
pub(crate) fn check_number(
    name: &str,
    given: usize,
    needed: usize,
    what: &str,
) -> Result<(), Fault> {
    if given == needed {
        return Ok(());
    }
    refuse!("{name} = {given} must be {needed}, the number of {what}")
}
