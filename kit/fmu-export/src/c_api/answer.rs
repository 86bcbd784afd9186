//! The result of an FMI call, which `fmi2` and `fmi3` convert to their own status type.

/// The result of an FMI call. There is no warning, which is only logged, because importers abort on
/// it; and no fatal error, which would mean that all instances are corrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// The call succeeded.
    Ok = 0,
    /// [`Fault::Discarded`](crate::core::fault::Fault::Discarded).
    Discard = 2,
    /// [`Fault::Refused`](crate::core::fault::Fault::Refused), or a panic.
    Error = 3,
}
