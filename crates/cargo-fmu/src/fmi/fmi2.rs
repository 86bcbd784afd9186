//! The C functions of FMI 2.0, loaded by name.

use std::ffi::c_int;

use fmu_description::fmi2_functions;

use super::symbols::{Pointer, Text, functions};

/// The logger. FMI declares it variadic; this one does not look at the arguments of the format, and
/// a variadic call with pointers and integers equals a plain one on Linux (x86-64, aarch64) and
/// Windows; not on Apple silicon.
pub type Logger = unsafe extern "C" fn(Pointer, Text, c_int, Text, Text);

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub struct Callbacks {
    /// Receives messages.
    pub logger: Option<Logger>,
    /// As `calloc`; NULL where an FMU declares canNotUseMemoryManagementFunctions.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> Pointer>,
    /// As `free`.
    pub free_memory: Option<unsafe extern "C" fn(Pointer)>,
    /// NULL: steps are synchronous.
    pub step_finished: Pointer,
    /// Handed to the logger.
    pub environment: Pointer,
}

fmi2_functions!(functions!);
