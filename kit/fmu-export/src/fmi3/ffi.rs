//! C types of FMI 3.0 (`fmi3PlatformTypes.h`, `fmi3FunctionTypes.h`) for `fmi3`, `wasm`, tests.
//!
//! Enumerations and `bool`s that the importer passes are plain numbers, because a value outside the
//! Rust type would be undefined behaviour.

pub use crate::c_api::files::ReceiveFile;
pub use crate::c_api::status::Status;
pub use std::ffi::{c_char, c_int, c_void};

/// `fmi3Instance`.
pub type Instance = *mut c_void;
/// `fmi3InstanceEnvironment`.
pub type InstanceEnvironment = *mut c_void;
/// `fmi3FMUState`; a handle that is looked up, never dereferenced.
pub type FmuState = *mut c_void;
/// `fmi3ValueReference`.
pub type ValueReference = u32;
/// `fmi3Boolean` and `fmi3Clock`, a `bool` of C: 0 or 1.
pub type Boolean = u8;
/// `fmi3String`.
pub type Str = *const c_char;
/// `fmi3Byte`.
pub type Byte = u8;
/// `fmi3Binary`.
pub type Binary = *const Byte;

/// `fmi3DependencyKind`: `fmi3Dependent`.
pub const DEPENDENT: c_int = 5;

/// `fmi3LogMessageCallback`. An exception of a C++ importer may pass through; longjmp may not.
pub type LogMessage =
    unsafe extern "C-unwind" fn(InstanceEnvironment, Status, category: Str, message: Str);
/// `fmi3IntermediateUpdateCallback`.
pub type IntermediateUpdate = unsafe extern "C-unwind" fn(
    InstanceEnvironment,
    time: f64,
    set_requested: Boolean,
    get_allowed: Boolean,
    step_finished: Boolean,
    can_return_early: Boolean,
    early_return_requested: *mut Boolean,
    early_return_time: *mut f64,
);
/// `fmi3ClockUpdateCallback`.
pub type ClockUpdate = unsafe extern "C-unwind" fn(InstanceEnvironment);
/// `fmi3LockPreemptionCallback` and `fmi3UnlockPreemptionCallback`.
pub type Preemption = unsafe extern "C-unwind" fn();
