//! The status that functions of FMI return, the same in both versions, for all functions.

/// `fmi2Status` and `fmi3Status`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The call succeeded.
    Ok = 0,
    /// Never returned, only logged: importers abort on it.
    Warning = 1,
    /// A step could not be done, a value is out of bounds, or there is no such status; the instance
    /// is as before. Or the step of FMI 2.0 was done in part (fmi2LastSuccessfulTime).
    Discard = 2,
    /// The call was wrong and the instance is as before; or a panic has made it unusable until a
    /// reset or a restored state.
    Error = 3,
    /// Never returned: it would mean that all instances are corrupt.
    Fatal = 4,
    /// Of FMI 2.0 only, and never returned: steps are synchronous.
    Pending = 5,
}
