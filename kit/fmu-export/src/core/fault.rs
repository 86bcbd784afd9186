//! Why an FMI call failed, independent of the version: `core` and the FMI functions return it.

use super::error::ModelError;

/// Why a call failed. The instance is as it was before the call.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The call was wrong, or the model refused it.
    Refused(String),
    /// A value out of bounds, a step that cannot be done, a missing status: others may succeed.
    Discarded(String),
    /// No variable has this number.
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

/// `Err` of [`Fault::Refused`] with a formatted message.
macro_rules! refuse {
    ($($text:tt)*) => { Err($crate::core::fault::Fault::refused(format_args!($($text)*))) };
}
pub(crate) use refuse;

/// `Err` of [`Fault::Discarded`] with a formatted message.
macro_rules! discard {
    ($($text:tt)*) => { Err($crate::core::fault::Fault::discarded(format_args!($($text)*))) };
}
pub(crate) use discard;

/// What the number of values of a call must be equal to, for messages.
pub(crate) const OF_VARIABLES: &str = "elements of these variables";

/// Refuses a wrong number of values.
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
