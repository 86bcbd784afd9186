//! What a C function answers: both versions of FMI number their statuses alike.

use std::ffi::c_int;

/// All is well.
pub const OK: c_int = 0;
/// Done, but there is something to say.
pub const WARNING: c_int = 1;
/// Not done, and nothing has changed.
pub const DISCARD: c_int = 2;
/// A wrong call.
pub const ERROR: c_int = 3;
/// `fmi2Pending`: a step in the background.
pub const PENDING: c_int = 5;
/// In place of a status: it was not called, because a value does not fit its type.
pub const UNFIT: c_int = -1;
/// In place of a status: the library does not export the function.
pub const ABSENT: c_int = 1000;
/// In place of a status: a text is at a place that cannot be read.
pub const NO_TEXT: c_int = 1001;

/// Name of a status, as in FMI 2.0.
pub fn name(status: c_int) -> String {
    let names = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
    let known = usize::try_from(status).ok().and_then(|k| names.get(k));
    match (known, status) {
        (Some(name), _) => format!("fmi2{name}"),
        (_, ABSENT) => "no answer, since the library does not export it".to_string(),
        (_, NO_TEXT) => "a pointer that leads to no text".to_string(),
        _ => format!("the number {status}, which is no fmi2Status"),
    }
}
