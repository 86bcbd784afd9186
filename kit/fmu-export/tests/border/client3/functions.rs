//! The C functions of FMI 3.0.

use fmu_export::ffi3::*;
use std::ffi::{c_int, c_void};

macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),*);)*) => {
        #[allow(clashing_extern_declarations, dead_code)]
        unsafe extern "C-unwind" {
            $(pub fn $name(c: Instance $(, $argument: $type)*) -> Status;)*
        }
    };
}

#[rustfmt::skip]
unsafe extern "C-unwind" {
    pub safe fn fmi3GetVersion() -> Str;
    pub fn fmi3InstantiateCoSimulation(name: Str, token: Str, resources: Str, visible: Boolean, on: Boolean, event_mode: Boolean, early: Boolean, required: *const u32, n: usize, environment: *mut c_void, log: Option<LogMessage>, update: Option<IntermediateUpdate>) -> Instance;
    pub fn fmi3InstantiateModelExchange(name: Str, token: Str, resources: Str, visible: Boolean, on: Boolean, environment: *mut c_void, log: Option<LogMessage>) -> Instance;
    pub fn fmi3InstantiateScheduledExecution(name: Str, token: Str, resources: Str, visible: Boolean, on: Boolean, environment: *mut c_void, log: Option<LogMessage>, clock: Option<ClockUpdate>, lock: Option<Preemption>, unlock: Option<Preemption>) -> Instance;
    pub fn fmi3FreeInstance(c: Instance);
    pub fn fmi3ExportFiles(context: *mut c_void, receive: Option<ReceiveFile>) -> c_int;
}

#[rustfmt::skip]
functions! {
    fmi3SetDebugLogging(on: Boolean, n: usize, categories: *const Str);
    fmi3EnterInitializationMode(tolerance_defined: Boolean, tolerance: f64, start: f64, stop_defined: Boolean, stop: f64);
    fmi3ExitInitializationMode();
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(a: *mut Boolean, b: *mut Boolean, c1: *mut Boolean, d: *mut Boolean, e: *mut Boolean, t: *mut f64);
    fmi3Terminate();
    fmi3Reset();
    fmi3DoStep(t: f64, h: f64, no_set_prior: Boolean, event: *mut Boolean, terminate: *mut Boolean, early: *mut Boolean, last: *mut f64);
    fmi3GetFloat32(vr: *const u32, n: usize, values: *mut f32, n_values: usize);
    fmi3GetFloat64(vr: *const u32, n: usize, values: *mut f64, n_values: usize);
    fmi3GetInt8(vr: *const u32, n: usize, values: *mut i8, n_values: usize);
    fmi3GetUInt8(vr: *const u32, n: usize, values: *mut u8, n_values: usize);
    fmi3GetInt16(vr: *const u32, n: usize, values: *mut i16, n_values: usize);
    fmi3GetUInt16(vr: *const u32, n: usize, values: *mut u16, n_values: usize);
    fmi3GetInt32(vr: *const u32, n: usize, values: *mut i32, n_values: usize);
    fmi3GetUInt32(vr: *const u32, n: usize, values: *mut u32, n_values: usize);
    fmi3GetInt64(vr: *const u32, n: usize, values: *mut i64, n_values: usize);
    fmi3GetUInt64(vr: *const u32, n: usize, values: *mut u64, n_values: usize);
    fmi3GetBoolean(vr: *const u32, n: usize, values: *mut Boolean, n_values: usize);
    fmi3GetString(vr: *const u32, n: usize, values: *mut Str, n_values: usize);
    fmi3GetBinary(vr: *const u32, n: usize, sizes: *mut usize, values: *mut Binary, n_values: usize);
    fmi3GetClock(vr: *const u32, n: usize, values: *mut Boolean);
    fmi3SetFloat32(vr: *const u32, n: usize, values: *const f32, n_values: usize);
    fmi3SetFloat64(vr: *const u32, n: usize, values: *const f64, n_values: usize);
    fmi3SetInt8(vr: *const u32, n: usize, values: *const i8, n_values: usize);
    fmi3SetUInt8(vr: *const u32, n: usize, values: *const u8, n_values: usize);
    fmi3SetInt16(vr: *const u32, n: usize, values: *const i16, n_values: usize);
    fmi3SetUInt16(vr: *const u32, n: usize, values: *const u16, n_values: usize);
    fmi3SetInt32(vr: *const u32, n: usize, values: *const i32, n_values: usize);
    fmi3SetUInt32(vr: *const u32, n: usize, values: *const u32, n_values: usize);
    fmi3SetInt64(vr: *const u32, n: usize, values: *const i64, n_values: usize);
    fmi3SetUInt64(vr: *const u32, n: usize, values: *const u64, n_values: usize);
    fmi3SetBoolean(vr: *const u32, n: usize, values: *const Boolean, n_values: usize);
    fmi3SetString(vr: *const u32, n: usize, values: *const Str, n_values: usize);
    fmi3SetBinary(vr: *const u32, n: usize, sizes: *const usize, values: *const Binary, n_values: usize);
    fmi3SetClock(vr: *const u32, n: usize, values: *const Boolean);
    fmi3GetNumberOfVariableDependencies(dependent: u32, n: *mut usize);
    fmi3GetVariableDependencies(dependent: u32, elements: *mut usize, independents: *mut u32, independent_elements: *mut usize, kinds: *mut c_int, n: usize);
    fmi3GetFMUState(state: *mut FmuState);
    fmi3SetFMUState(state: FmuState);
    fmi3FreeFMUState(state: *mut FmuState);
    fmi3SerializedFMUStateSize(state: FmuState, size: *mut usize);
    fmi3SerializeFMUState(state: FmuState, bytes: *mut Byte, size: usize);
    fmi3DeserializeFMUState(bytes: *const Byte, size: usize, state: *mut FmuState);
    fmi3GetDirectionalDerivative(unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize, seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize);
    fmi3GetAdjointDerivative(unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize, seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize);
    fmi3GetOutputDerivatives(vr: *const u32, n: usize, orders: *const i32, values: *mut f64, n_values: usize);
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3GetIntervalDecimal(vr: *const u32, n: usize, intervals: *mut f64, qualifiers: *mut c_int);
    fmi3GetIntervalFraction(vr: *const u32, n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut c_int);
    fmi3GetShiftDecimal(vr: *const u32, n: usize, shifts: *mut f64);
    fmi3GetShiftFraction(vr: *const u32, n: usize, counters: *mut u64, resolutions: *mut u64);
    fmi3SetIntervalDecimal(vr: *const u32, n: usize, intervals: *const f64);
    fmi3SetIntervalFraction(vr: *const u32, n: usize, counters: *const u64, resolutions: *const u64);
    fmi3SetShiftDecimal(vr: *const u32, n: usize, shifts: *const f64);
    fmi3SetShiftFraction(vr: *const u32, n: usize, counters: *const u64, resolutions: *const u64);
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(no_set_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean);
    fmi3SetTime(time: f64);
    fmi3SetContinuousStates(states: *const f64, n: usize);
    fmi3GetContinuousStateDerivatives(derivatives: *mut f64, n: usize);
    fmi3GetEventIndicators(indicators: *mut f64, n: usize);
    fmi3GetContinuousStates(states: *mut f64, n: usize);
    fmi3GetNominalsOfContinuousStates(nominals: *mut f64, n: usize);
    fmi3GetNumberOfEventIndicators(n: *mut usize);
    fmi3GetNumberOfContinuousStates(n: *mut usize);
    fmi3ActivateModelPartition(clock: u32, time: f64);
}
