//! The C functions of FMI 3.0, loaded by name.

use std::ffi::c_int;

use fmu_description::fmi3_functions;

use super::symbols::{Pointer, Text, functions};

/// `fmi3LogMessageCallback`.
pub type Logger = unsafe extern "C" fn(Pointer, c_int, Text, Text);

fmi3_functions!(functions!);
