//! The C functions of FMI 3.0, loaded by name.

use std::ffi::c_int;

use super::symbols::{Pointer, Text, functions};

/// `fmi3LogMessageCallback`.
pub type Logger = unsafe extern "C" fn(Pointer, c_int, Text, Text);

functions! {
    fmi3GetVersion() -> Text;
    fmi3SetDebugLogging(Pointer, bool, usize, *const Text) -> c_int;
    fmi3InstantiateModelExchange(Text, Text, Text, bool, bool, Pointer, Option<Logger>) -> Pointer;
    fmi3InstantiateCoSimulation(Text, Text, Text, bool, bool, bool, bool, *const u32, usize, Pointer, Option<Logger>, Pointer) -> Pointer;
    fmi3InstantiateScheduledExecution(Text, Text, Text, bool, bool, Pointer, Option<Logger>, Pointer, Pointer, Pointer) -> Pointer;
    fmi3FreeInstance(Pointer);
    fmi3EnterInitializationMode(Pointer, bool, f64, f64, bool, f64) -> c_int;
    fmi3ExitInitializationMode(Pointer) -> c_int;
    fmi3EnterEventMode(Pointer) -> c_int;
    fmi3Terminate(Pointer) -> c_int;
    fmi3Reset(Pointer) -> c_int;
    fmi3GetFloat32(Pointer, *const u32, usize, *mut f32, usize) -> c_int;
    fmi3GetFloat64(Pointer, *const u32, usize, *mut f64, usize) -> c_int;
    fmi3GetInt8(Pointer, *const u32, usize, *mut i8, usize) -> c_int;
    fmi3GetUInt8(Pointer, *const u32, usize, *mut u8, usize) -> c_int;
    fmi3GetInt16(Pointer, *const u32, usize, *mut i16, usize) -> c_int;
    fmi3GetUInt16(Pointer, *const u32, usize, *mut u16, usize) -> c_int;
    fmi3GetInt32(Pointer, *const u32, usize, *mut i32, usize) -> c_int;
    fmi3GetUInt32(Pointer, *const u32, usize, *mut u32, usize) -> c_int;
    fmi3GetInt64(Pointer, *const u32, usize, *mut i64, usize) -> c_int;
    fmi3GetUInt64(Pointer, *const u32, usize, *mut u64, usize) -> c_int;
    fmi3GetBoolean(Pointer, *const u32, usize, *mut bool, usize) -> c_int;
    fmi3GetString(Pointer, *const u32, usize, *mut Text, usize) -> c_int;
    fmi3GetBinary(Pointer, *const u32, usize, *mut usize, *mut Pointer, usize) -> c_int;
    fmi3GetClock(Pointer, *const u32, usize, *mut bool) -> c_int;
    fmi3SetFloat32(Pointer, *const u32, usize, *const f32, usize) -> c_int;
    fmi3SetFloat64(Pointer, *const u32, usize, *const f64, usize) -> c_int;
    fmi3SetInt8(Pointer, *const u32, usize, *const i8, usize) -> c_int;
    fmi3SetUInt8(Pointer, *const u32, usize, *const u8, usize) -> c_int;
    fmi3SetInt16(Pointer, *const u32, usize, *const i16, usize) -> c_int;
    fmi3SetUInt16(Pointer, *const u32, usize, *const u16, usize) -> c_int;
    fmi3SetInt32(Pointer, *const u32, usize, *const i32, usize) -> c_int;
    fmi3SetUInt32(Pointer, *const u32, usize, *const u32, usize) -> c_int;
    fmi3SetInt64(Pointer, *const u32, usize, *const i64, usize) -> c_int;
    fmi3SetUInt64(Pointer, *const u32, usize, *const u64, usize) -> c_int;
    fmi3SetBoolean(Pointer, *const u32, usize, *const bool, usize) -> c_int;
    fmi3SetString(Pointer, *const u32, usize, *const Text, usize) -> c_int;
    fmi3SetBinary(Pointer, *const u32, usize, *const usize, *const Pointer, usize) -> c_int;
    fmi3SetClock(Pointer, *const u32, usize, *const bool) -> c_int;
    fmi3GetNumberOfVariableDependencies(Pointer, u32, *mut usize) -> c_int;
    fmi3GetVariableDependencies(Pointer, u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize) -> c_int;
    fmi3GetFMUState(Pointer, *mut Pointer) -> c_int;
    fmi3SetFMUState(Pointer, Pointer) -> c_int;
    fmi3FreeFMUState(Pointer, *mut Pointer) -> c_int;
    fmi3SerializedFMUStateSize(Pointer, Pointer, *mut usize) -> c_int;
    fmi3SerializeFMUState(Pointer, Pointer, *mut u8, usize) -> c_int;
    fmi3DeserializeFMUState(Pointer, *const u8, usize, *mut Pointer) -> c_int;
    fmi3GetDirectionalDerivative(Pointer, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
    fmi3GetAdjointDerivative(Pointer, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
    fmi3EnterConfigurationMode(Pointer) -> c_int;
    fmi3ExitConfigurationMode(Pointer) -> c_int;
    fmi3GetIntervalDecimal(Pointer, *const u32, usize, *mut f64, *mut c_int) -> c_int;
    fmi3GetIntervalFraction(Pointer, *const u32, usize, *mut u64, *mut u64, *mut c_int) -> c_int;
    fmi3GetShiftDecimal(Pointer, *const u32, usize, *mut f64) -> c_int;
    fmi3GetShiftFraction(Pointer, *const u32, usize, *mut u64, *mut u64) -> c_int;
    fmi3SetIntervalDecimal(Pointer, *const u32, usize, *const f64) -> c_int;
    fmi3SetIntervalFraction(Pointer, *const u32, usize, *const u64, *const u64) -> c_int;
    fmi3SetShiftDecimal(Pointer, *const u32, usize, *const f64) -> c_int;
    fmi3SetShiftFraction(Pointer, *const u32, usize, *const u64, *const u64) -> c_int;
    fmi3EvaluateDiscreteStates(Pointer) -> c_int;
    fmi3UpdateDiscreteStates(Pointer, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
    fmi3EnterStepMode(Pointer) -> c_int;
    fmi3GetOutputDerivatives(Pointer, *const u32, usize, *const c_int, *mut f64, usize) -> c_int;
    fmi3DoStep(Pointer, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
}
