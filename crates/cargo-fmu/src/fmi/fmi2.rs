//! The C functions of FMI 2.0 for co-simulation, loaded by name. Enumerations are plain integers
//! here: what a broken FMU returns must not be undefined behaviour in the one who calls it.

use std::ffi::c_int;

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

functions! {
    fmi2GetTypesPlatform() -> Text;
    fmi2GetVersion() -> Text;
    fmi2SetDebugLogging(Pointer, c_int, usize, *const Text) -> c_int;
    fmi2Instantiate(Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Pointer;
    fmi2FreeInstance(Pointer);
    fmi2SetupExperiment(Pointer, c_int, f64, f64, c_int, f64) -> c_int;
    fmi2EnterInitializationMode(Pointer) -> c_int;
    fmi2ExitInitializationMode(Pointer) -> c_int;
    fmi2Terminate(Pointer) -> c_int;
    fmi2Reset(Pointer) -> c_int;
    fmi2GetReal(Pointer, *const u32, usize, *mut f64) -> c_int;
    fmi2GetInteger(Pointer, *const u32, usize, *mut c_int) -> c_int;
    fmi2GetBoolean(Pointer, *const u32, usize, *mut c_int) -> c_int;
    fmi2GetString(Pointer, *const u32, usize, *mut Text) -> c_int;
    fmi2SetReal(Pointer, *const u32, usize, *const f64) -> c_int;
    fmi2SetInteger(Pointer, *const u32, usize, *const c_int) -> c_int;
    fmi2SetBoolean(Pointer, *const u32, usize, *const c_int) -> c_int;
    fmi2SetString(Pointer, *const u32, usize, *const Text) -> c_int;
    fmi2GetFMUstate(Pointer, *mut Pointer) -> c_int;
    fmi2SetFMUstate(Pointer, Pointer) -> c_int;
    fmi2FreeFMUstate(Pointer, *mut Pointer) -> c_int;
    fmi2SerializedFMUstateSize(Pointer, Pointer, *mut usize) -> c_int;
    fmi2SerializeFMUstate(Pointer, Pointer, *mut u8, usize) -> c_int;
    fmi2DeSerializeFMUstate(Pointer, *const u8, usize, *mut Pointer) -> c_int;
    fmi2GetDirectionalDerivative(Pointer, *const u32, usize, *const u32, usize, *const f64, *mut f64) -> c_int;
    fmi2SetRealInputDerivatives(Pointer, *const u32, usize, *const c_int, *const f64) -> c_int;
    fmi2GetRealOutputDerivatives(Pointer, *const u32, usize, *const c_int, *mut f64) -> c_int;
    fmi2DoStep(Pointer, f64, f64, c_int) -> c_int;
    fmi2CancelStep(Pointer) -> c_int;
    fmi2GetStatus(Pointer, c_int, *mut c_int) -> c_int;
    fmi2GetRealStatus(Pointer, c_int, *mut f64) -> c_int;
    fmi2GetIntegerStatus(Pointer, c_int, *mut c_int) -> c_int;
    fmi2GetBooleanStatus(Pointer, c_int, *mut c_int) -> c_int;
    fmi2GetStringStatus(Pointer, c_int, *mut Text) -> c_int;
}
