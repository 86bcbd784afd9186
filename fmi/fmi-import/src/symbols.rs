//! Statuses and types of the C functions.

use std::ffi::c_int;

pub use crate::calls::ABSENT;
pub use crate::standard::{Pointer, Text};

/// Status: all is well.
pub const OK: c_int = 0;
/// Status: done, but something is to be told.
pub const WARNING: c_int = 1;
/// Status: not done, and nothing has changed.
pub const DISCARD: c_int = 2;
/// Status: a wrong call.
pub const ERROR: c_int = 3;
