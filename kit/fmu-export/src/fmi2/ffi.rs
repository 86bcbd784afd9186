//! The C types of FMI 2.0 (`fmi2TypesPlatform.h`, `fmi2FunctionTypes.h`), for `fmi2` and tests.
//!
//! Enumerations that the importer passes are plain `c_int`, because a value outside a Rust
//! enumeration would be undefined behaviour.

pub use crate::c_api::status::Status;
pub use std::ffi::{c_char, c_int, c_uint, c_void};

/// `fmi2Component`.
pub type Component = *mut c_void;
/// `fmi2ComponentEnvironment`.
pub type ComponentEnvironment = *mut c_void;
/// `fmi2FMUstate`; a handle that is looked up, never dereferenced.
pub type FmuState = *mut c_void;
/// `fmi2ValueReference`.
pub type ValueReference = c_uint;
/// `fmi2Real`.
pub type Real = f64;
/// `fmi2Integer`.
pub type Integer = c_int;
/// `fmi2Boolean`: 0 or 1.
pub type Boolean = c_int;
/// `fmi2String`.
pub type Str = *const c_char;
/// `fmi2Byte`.
pub type Byte = c_char;

/// `fmi2Type`: `fmi2CoSimulation`.
pub const CO_SIMULATION: c_int = 1;

/// `fmi2Type`: `fmi2ModelExchange`.
pub const MODEL_EXCHANGE: c_int = 0;

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(missing_docs)] // named as in the standard
pub struct EventInfo {
    pub new_discrete_states_needed: Boolean,
    pub terminate_simulation: Boolean,
    pub nominals_of_continuous_states_changed: Boolean,
    pub values_of_continuous_states_changed: Boolean,
    pub next_event_time_defined: Boolean,
    pub next_event_time: Real,
}

/// `fmi2StatusKind`: `fmi2DoStepStatus`.
pub const DO_STEP_STATUS: c_int = 0;
/// `fmi2StatusKind`: `fmi2PendingStatus`.
pub const PENDING_STATUS: c_int = 1;
/// `fmi2StatusKind`: `fmi2LastSuccessfulTime`.
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2StatusKind`: `fmi2Terminated`.
pub const TERMINATED: c_int = 3;

/// `fmi2CallbackLogger`. An exception of a C++ importer may pass through; longjmp may not.
#[cfg(not(miri))]
pub type CallbackLogger =
    unsafe extern "C-unwind" fn(ComponentEnvironment, Str, Status, Str, message: Str, ...);
/// The same without variable arguments, which Miri cannot call and which are never passed.
#[cfg(miri)]
pub type CallbackLogger =
    unsafe extern "C-unwind" fn(ComponentEnvironment, Str, Status, Str, message: Str);
/// `fmi2CallbackAllocateMemory`.
pub type CallbackAllocateMemory = unsafe extern "C" fn(usize, usize) -> *mut c_void;
/// `fmi2CallbackFreeMemory`.
pub type CallbackFreeMemory = unsafe extern "C" fn(*mut c_void);
/// `fmi2StepFinished`.
pub type StepFinished = unsafe extern "C" fn(ComponentEnvironment, Status);

/// `fmi2CallbackFunctions`. Only the logger is used (`canNotUseMemoryManagementFunctions`); each
/// may be NULL.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CallbackFunctions {
    /// Receives messages.
    pub logger: Option<CallbackLogger>,
    /// Not used.
    pub allocate_memory: Option<CallbackAllocateMemory>,
    /// Not used.
    pub free_memory: Option<CallbackFreeMemory>,
    /// Not used: steps are synchronous.
    pub step_finished: Option<StepFinished>,
    /// Handed back to the logger.
    pub component_environment: ComponentEnvironment,
}

pub use crate::c_api::files::ReceiveFile;
