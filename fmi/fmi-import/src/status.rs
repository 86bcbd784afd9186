//! Statuses that a C function returns, which both versions of FMI number alike, and codes in their
//! place, for the master, the check and `torture`.
//!
//! ```
//! use fmi_import::status;
//! assert_eq!(status::name(status::DISCARD), "fmi2Discard");
//! ```

use std::ffi::c_int;

/// `fmi2OK`: the call succeeded.
pub const OK: c_int = 0;
/// `fmi2Warning`: the call succeeded, with a message.
pub const WARNING: c_int = 1;
/// `fmi2Discard`: the call was not carried out, and the instance is unchanged.
pub const DISCARD: c_int = 2;
/// `fmi2Error`: the call was wrong.
pub const ERROR: c_int = 3;
/// `fmi2Fatal`: the library cannot be used any more.
pub const FATAL: c_int = 4;
/// `fmi2Pending`: a step in the background.
pub const PENDING: c_int = 5;
/// In place of a status: nothing was called, because a value is not in the range of its type.
pub const UNFIT: c_int = -1;
/// In place of a status: the library does not export the function, or FMI does not have it.
pub const ABSENT: c_int = 1000;
/// In place of a status: the pointer to a text cannot be read.
pub const NO_TEXT: c_int = 1001;
/// In place of a status: the bytes of a value cannot be read, or are more than 256 MiB.
pub const NO_BYTES: c_int = 1002;

/// Name of a status, as in FMI 2.0.
pub fn name(status: c_int) -> String {
    let names = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
    let known = usize::try_from(status).ok().and_then(|k| names.get(k));
    match (known, status) {
        (Some(name), _) => format!("fmi2{name}"),
        (_, ABSENT) => "no answer, since the library does not export it".to_string(),
        (_, NO_TEXT) => "a pointer that leads to no text".to_string(),
        (_, NO_BYTES) => "a value that cannot be read, or of more than 256 MiB".to_string(),
        _ => format!("the number {status}, which is no fmi2Status"),
    }
}
