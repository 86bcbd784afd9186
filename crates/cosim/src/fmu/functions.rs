//! The functions of FMI 2.0 and 3.0 that the master calls, as a library exports them. A function
//! that is missing is missed when it is called, not when the library is loaded: many libraries lack
//! some that they never need.
#![allow(unsafe_code, non_snake_case, missing_docs)]

use std::ffi::{c_char, c_int, c_void};

use super::library::Library;

/// An instance as the library knows it.
pub type Handle = *mut c_void;
/// A C string.
pub type Text = *const c_char;

/// What FMI 2.0 calls `fmi2CallbackFunctions`.
#[repr(C)]
pub struct Callbacks {
    /// Variadic.
    pub logger: unsafe extern "C" fn(Handle, Text, c_int, Text, Text, ...),
    pub allocate_memory: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    pub free_memory: unsafe extern "C" fn(*mut c_void),
    pub step_finished: *const c_void,
    pub environment: Handle,
}

/// The logger of FMI 3.0: environment, status, category, message.
pub type Logger3 = unsafe extern "C" fn(Handle, c_int, Text, Text);

macro_rules! functions {
    ($(#[$doc:meta])* $name:ident { $($function:ident($($argument:ty),* $(,)?) $(-> $result:ty)?;)* }) => {
        $(#[$doc])*
        pub struct $name {
            $(pub $function: Option<unsafe extern "C" fn($($argument),*) $(-> $result)?>,)*
            _library: Library,
        }

        impl $name {
            /// The functions that `library` exports.
            pub fn of(library: Library) -> Self {
                Self {
                    // SAFETY: the type is that of the function in the standard's headers.
                    $($function: unsafe { library.function(stringify!($function)) },)*
                    _library: library,
                }
            }
        }
    };
}

functions! {
    /// Of FMI 2.0, by their C names.
    Functions2 {
        fmi2Instantiate(Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Handle;
        fmi2FreeInstance(Handle);
        fmi2SetDebugLogging(Handle, c_int, usize, *const Text) -> c_int;
        fmi2SetupExperiment(Handle, c_int, f64, f64, c_int, f64) -> c_int;
        fmi2EnterInitializationMode(Handle) -> c_int;
        fmi2ExitInitializationMode(Handle) -> c_int;
        fmi2Terminate(Handle) -> c_int;
        fmi2Reset(Handle) -> c_int;
        fmi2GetReal(Handle, *const u32, usize, *mut f64) -> c_int;
        fmi2GetInteger(Handle, *const u32, usize, *mut c_int) -> c_int;
        fmi2GetBoolean(Handle, *const u32, usize, *mut c_int) -> c_int;
        fmi2SetReal(Handle, *const u32, usize, *const f64) -> c_int;
        fmi2SetInteger(Handle, *const u32, usize, *const c_int) -> c_int;
        fmi2SetBoolean(Handle, *const u32, usize, *const c_int) -> c_int;
        fmi2SetString(Handle, *const u32, usize, *const Text) -> c_int;
        fmi2SetRealInputDerivatives(Handle, *const u32, usize, *const c_int, *const f64) -> c_int;
        fmi2GetRealOutputDerivatives(Handle, *const u32, usize, *const c_int, *mut f64) -> c_int;
        fmi2DoStep(Handle, f64, f64, c_int) -> c_int;
        fmi2GetRealStatus(Handle, c_int, *mut f64) -> c_int;
        fmi2GetBooleanStatus(Handle, c_int, *mut c_int) -> c_int;
        fmi2GetString(Handle, *const u32, usize, *mut Text) -> c_int;
    }
}

functions! {
    /// Of FMI 3.0, by their C names. A pointer to values is untyped where the type says nothing
    /// more.
    Functions3 {
        fmi3InstantiateCoSimulation(
            Text, Text, Text, bool, bool, bool, bool, *const u32, usize, Handle, Logger3, *const c_void
        ) -> Handle;
        fmi3FreeInstance(Handle);
        fmi3SetDebugLogging(Handle, bool, usize, *const Text) -> c_int;
        fmi3EnterInitializationMode(Handle, bool, f64, f64, bool, f64) -> c_int;
        fmi3ExitInitializationMode(Handle) -> c_int;
        fmi3EnterEventMode(Handle) -> c_int;
        fmi3UpdateDiscreteStates(
            Handle, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64
        ) -> c_int;
        fmi3EnterStepMode(Handle) -> c_int;
        fmi3Terminate(Handle) -> c_int;
        fmi3DoStep(Handle, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
        fmi3GetOutputDerivatives(Handle, *const u32, usize, *const i32, *mut f64, usize) -> c_int;
        fmi3GetFloat32(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetFloat64(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetInt8(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetUInt8(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetInt16(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetUInt16(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetInt32(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetUInt32(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetInt64(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetUInt64(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3GetBoolean(Handle, *const u32, usize, *mut c_void, usize) -> c_int;
        fmi3SetFloat32(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetFloat64(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetInt8(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetUInt8(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetInt16(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetUInt16(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetInt32(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetUInt32(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetInt64(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetUInt64(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetBoolean(Handle, *const u32, usize, *const c_void, usize) -> c_int;
        fmi3SetString(Handle, *const u32, usize, *const Text, usize) -> c_int;
        fmi3GetString(Handle, *const u32, usize, *mut Text, usize) -> c_int;
        fmi3GetBinary(Handle, *const u32, usize, *mut usize, *mut *const u8, usize) -> c_int;
        fmi3SetBinary(Handle, *const u32, usize, *const usize, *const *const u8, usize) -> c_int;
        fmi3SetClock(Handle, *const u32, usize, *const bool) -> c_int;
        fmi3GetIntervalDecimal(Handle, *const u32, usize, *mut f64, *mut c_int) -> c_int;
        fmi3GetShiftDecimal(Handle, *const u32, usize, *mut f64) -> c_int;
    }
}

/// Calls a function of a library, or answers that it is missing.
macro_rules! call {
    ($api:expr, $function:ident($($argument:expr),* $(,)?)) => {
        match $api.$function {
            Some(function) => Answer::new(function($($argument),*), stringify!($function)),
            None => Answer::missing(stringify!($function)),
        }
    };
}
pub(crate) use call;
