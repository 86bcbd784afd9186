//! Functions of what this FMU declares not to have: variables of other types, clocks, structural parameters, Model Exchange, Scheduled
//! Execution. Each is refused by name, and leaves the instance as it is.

use super::calls;
use super::ffi::*;
use super::instance::{Fmi3, enter};
use super::values::no_such_type;
use crate::Model;
use crate::border::arguments::array;
use crate::core::fault::refuse;

macro_rules! types {
    ($($function:ident $c_name:literal $call:ident $set:literal $type:literal($($argument:ident: $c_type:ty),*);)*) => {$(
        #[doc = concat!($c_name, ".\n\n# Safety\nSee [`entry`](super::entry).")]
        pub unsafe fn $function<M: Model>(
            c: Instance,
            vr: *const ValueReference,
            n: usize,
            $($argument: $c_type),*
        ) -> Status {
            $(let _ = $argument;)*
            // SAFETY: forwarded.
            unsafe { no_such_type::<M>(c, calls::$call, $type, $set, vr, n) }
        }
    )*};
}

types! {
    get_float32 "fmi3GetFloat32" GET_FLOAT32 false "Float32"(values: *mut f32, n_values: usize);
    get_int8 "fmi3GetInt8" GET_INT8 false "Int8"(values: *mut i8, n_values: usize);
    get_uint8 "fmi3GetUInt8" GET_UINT8 false "UInt8"(values: *mut u8, n_values: usize);
    get_int16 "fmi3GetInt16" GET_INT16 false "Int16"(values: *mut i16, n_values: usize);
    get_uint16 "fmi3GetUInt16" GET_UINT16 false "UInt16"(values: *mut u16, n_values: usize);
    get_uint32 "fmi3GetUInt32" GET_UINT32 false "UInt32"(values: *mut u32, n_values: usize);
    get_uint64 "fmi3GetUInt64" GET_UINT64 false "UInt64"(values: *mut u64, n_values: usize);
    get_binary "fmi3GetBinary" GET_BINARY false "Binary"(sizes: *mut usize, values: *mut Binary, n_values: usize);
    get_clock "fmi3GetClock" GET_CLOCK false "Clock"(values: *mut Boolean);
    set_float32 "fmi3SetFloat32" SET_FLOAT32 true "Float32"(values: *const f32, n_values: usize);
    set_int8 "fmi3SetInt8" SET_INT8 true "Int8"(values: *const i8, n_values: usize);
    set_uint8 "fmi3SetUInt8" SET_UINT8 true "UInt8"(values: *const u8, n_values: usize);
    set_int16 "fmi3SetInt16" SET_INT16 true "Int16"(values: *const i16, n_values: usize);
    set_uint16 "fmi3SetUInt16" SET_UINT16 true "UInt16"(values: *const u16, n_values: usize);
    set_uint32 "fmi3SetUInt32" SET_UINT32 true "UInt32"(values: *const u32, n_values: usize);
    set_uint64 "fmi3SetUInt64" SET_UINT64 true "UInt64"(values: *const u64, n_values: usize);
    set_binary "fmi3SetBinary" SET_BINARY true "Binary"(sizes: *const usize, values: *const Binary, n_values: usize);
    set_clock "fmi3SetClock" SET_CLOCK true "Clock"(values: *const Boolean);
}

macro_rules! clocks {
    ($($function:ident $c_name:literal $call:ident($($argument:ident: $c_type:ty),*);)*) => {$(
        #[doc = concat!($c_name, ".\n\n# Safety\nSee [`entry`](super::entry).")]
        pub unsafe fn $function<M: Model>(
            c: Instance,
            vr: *const ValueReference,
            n: usize,
            $($argument: $c_type),*
        ) -> Status {
            $(let _ = $argument;)*
            // SAFETY: forwarded.
            unsafe {
                enter::<M, Fmi3>(c, calls::$call, |b| {
                    let Some(number) = array("valueReferences", vr, n)?.at(0) else {
                        return Ok(());
                    };
                    let (run, first, _) = b.instance.layout.block(number)?;
                    let (name, kind) = (run.row.element_name(first), run.row.kind(b.instance.names));
                    refuse!("`{name}` is {kind}; it must be a Clock, and this FMU has none")
                })
            }
        }
    )*};
}

clocks! {
    get_interval_decimal "fmi3GetIntervalDecimal" GET_INTERVAL_DECIMAL(intervals: *mut f64, qualifiers: *mut c_int);
    get_interval_fraction "fmi3GetIntervalFraction" GET_INTERVAL_FRACTION(counters: *mut u64, resolutions: *mut u64, qualifiers: *mut c_int);
    get_shift_decimal "fmi3GetShiftDecimal" GET_SHIFT_DECIMAL(shifts: *mut f64);
    get_shift_fraction "fmi3GetShiftFraction" GET_SHIFT_FRACTION(counters: *mut u64, resolutions: *mut u64);
    set_interval_decimal "fmi3SetIntervalDecimal" SET_INTERVAL_DECIMAL(intervals: *const f64);
    set_interval_fraction "fmi3SetIntervalFraction" SET_INTERVAL_FRACTION(counters: *const u64, resolutions: *const u64);
    set_shift_decimal "fmi3SetShiftDecimal" SET_SHIFT_DECIMAL(shifts: *const f64);
    set_shift_fraction "fmi3SetShiftFraction" SET_SHIFT_FRACTION(counters: *const u64, resolutions: *const u64);
}

macro_rules! refused {
    ($($function:ident $c_name:literal $call:ident($($argument:ident: $c_type:ty),*) $reason:expr;)*) => {$(
        #[doc = concat!($c_name, ".\n\n# Safety\nSee [`entry`](super::entry).")]
        pub unsafe fn $function<M: Model>(c: Instance, $($argument: $c_type),*) -> Status {
            $(let _ = $argument;)*
            // SAFETY: forwarded.
            unsafe { enter::<M, Fmi3>(c, calls::$call, |_| refuse!("{}", $reason)) }
        }
    )*};
}

const MODEL_EXCHANGE: &str =
    "this function is for Model Exchange, and this FMU offers Co-Simulation only";
const SCHEDULED: &str =
    "this function is for Scheduled Execution, and this FMU offers Co-Simulation only";
const STRUCTURAL: &str =
    "this FMU has no structural parameters, so there is no Configuration Mode to enter or leave";

refused! {
    enter_configuration_mode "fmi3EnterConfigurationMode" ENTER_CONFIGURATION_MODE() STRUCTURAL;
    exit_configuration_mode "fmi3ExitConfigurationMode" EXIT_CONFIGURATION_MODE() STRUCTURAL;
    enter_continuous_time_mode "fmi3EnterContinuousTimeMode" ENTER_CONTINUOUS_TIME_MODE() MODEL_EXCHANGE;
    completed_integrator_step "fmi3CompletedIntegratorStep" COMPLETED_INTEGRATOR_STEP(no_set_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean) MODEL_EXCHANGE;
    set_time "fmi3SetTime" SET_TIME(time: f64) MODEL_EXCHANGE;
    set_continuous_states "fmi3SetContinuousStates" SET_CONTINUOUS_STATES(states: *const f64, n: usize) MODEL_EXCHANGE;
    get_continuous_state_derivatives "fmi3GetContinuousStateDerivatives" GET_STATE_DERIVATIVES(derivatives: *mut f64, n: usize) MODEL_EXCHANGE;
    get_event_indicators "fmi3GetEventIndicators" GET_EVENT_INDICATORS(indicators: *mut f64, n: usize) MODEL_EXCHANGE;
    get_continuous_states "fmi3GetContinuousStates" GET_CONTINUOUS_STATES(states: *mut f64, n: usize) MODEL_EXCHANGE;
    get_nominals_of_continuous_states "fmi3GetNominalsOfContinuousStates" GET_NOMINALS(nominals: *mut f64, n: usize) MODEL_EXCHANGE;
    get_number_of_event_indicators "fmi3GetNumberOfEventIndicators" GET_NUMBER_OF_INDICATORS(n: *mut usize) MODEL_EXCHANGE;
    get_number_of_continuous_states "fmi3GetNumberOfContinuousStates" GET_NUMBER_OF_STATES(n: *mut usize) MODEL_EXCHANGE;
    activate_model_partition "fmi3ActivateModelPartition" ACTIVATE_MODEL_PARTITION(clock: ValueReference, time: f64) SCHEDULED;
}
