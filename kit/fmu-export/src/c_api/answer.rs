//! How a call is answered, in no version's words.

/// How a call is answered. A warning is never returned, only logged: importers abort on it. Nor is
/// fatality, which would mean that all instances are corrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// All well.
    Ok = 0,
    /// [`Fault::Discarded`](crate::core::fault::Fault::Discarded).
    Discard = 2,
    /// [`Fault::Refused`](crate::core::fault::Fault::Refused), or a panic.
    Error = 3,
}
