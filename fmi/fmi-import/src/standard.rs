//! The C functions of FMI 2.0 and 3.0 in two tables: name, interface, states of co-simulation in
//! which an importer may call it, and C type; `fmu-check` and `torture` use them too. Enumerations
//! are integers, so that a broken FMU that returns an unknown value causes no undefined behaviour.
//!
//! ```
//! use fmi_import::standard::{Mode, is_allowed};
//! assert!(is_allowed("fmi2DoStep", Mode::Stepping) && !is_allowed("fmi2DoStep", Mode::Instantiated));
//! ```

use std::ffi::{c_char, c_int, c_void};

/// An instance, a saved state, an environment.
pub type Pointer = *mut c_void;
/// A C string.
pub type Text = *const c_char;

/// `fmi3LogMessageCallback`: environment, status, category, message.
pub type Logger = unsafe extern "C" fn(Pointer, c_int, Text, Text);

/// A C function of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name.
    pub name: &'static str,
    /// Which FMUs must export it.
    pub interface: Interface,
    /// States in which it may be called, as bits.
    states: u8,
}

/// Which FMUs must export a function: all, or those with one of the interfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // named as in the standard
pub enum Interface {
    Shared,
    CoSimulation,
    ModelExchange,
    ScheduledExecution,
}

/// States of co-simulation: FMI 2.0.4, section 4.2.4, and FMI 3.0.1, section 4.2.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// After fmi2Instantiate and fmi2Reset.
    Instantiated,
    /// Between fmi2EnterInitializationMode and fmi2ExitInitializationMode.
    Initialization,
    /// Event Mode of FMI 3.0.
    Event,
    /// Ready for a step.
    Stepping,
    /// Ready for a step in FMI 3.0 after a set: nothing may be read before the next step.
    SteppingAfterSet,
    /// After fmi2Terminate.
    Terminated,
}

impl Mode {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Instantiated,
        Self::Initialization,
        Self::Event,
        Self::Stepping,
        Self::SteppingAfterSet,
        Self::Terminated,
    ];

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

// The states in the tables below, as bits.
const INSTANTIATED: u8 = Mode::Instantiated.bit();
const INITIALIZATION_MODE: u8 = Mode::Initialization.bit();
const EVENT_MODE: u8 = Mode::Event.bit();
const STEP_MODE: u8 = Mode::Stepping.bit();
/// Step Mode, when something was set since the last step.
const AFTER_SET: u8 = Mode::SteppingAfterSet.bit();
const TERMINATED: u8 = Mode::Terminated.bit();
const ANY: u8 =
    INSTANTIATED | INITIALIZATION_MODE | EVENT_MODE | STEP_MODE | AFTER_SET | TERMINATED;
/// States in which FMI 2.0 allows setting and getting values.
const SET_2: u8 = INSTANTIATED | INITIALIZATION_MODE | STEP_MODE;
const GET_2: u8 = INITIALIZATION_MODE | STEP_MODE | TERMINATED;
/// States in which FMI 3.0 allows setting and getting values.
const SET_3: u8 = INSTANTIATED | INITIALIZATION_MODE | EVENT_MODE | STEP_MODE | AFTER_SET;
const GET_3: u8 = INSTANTIATED | INITIALIZATION_MODE | EVENT_MODE | STEP_MODE | TERMINATED;
/// Not in co-simulation.
const NONE: u8 = 0;

impl Function {
    /// The function of this name, of FMI 2.0 or 3.0.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        FMI2.iter().chain(FMI3).find(|f| f.name == name)
    }

    /// Whether it may be called in this state, of an FMU without clocks and structural parameters.
    #[must_use]
    pub fn is_allowed(&self, mode: Mode) -> bool {
        self.states & mode.bit() != 0
    }
}

/// Whether the function of this name, of either version, may be called in this state.
///
/// # Panics
/// FMI has no such function.
#[must_use]
pub fn is_allowed(name: &str, mode: Mode) -> bool {
    let function = Function::named(name);
    function.expect("a function of FMI").is_allowed(mode)
}

macro_rules! list {
    ($list:ident $($name:ident $interface:ident [$($states:tt)*] ($($type:ty),*) $(-> $result:ty)?;)*) => {
        /// All functions of this version.
        pub const $list: &[Function] = &[$(Function {
            name: stringify!($name),
            interface: Interface::$interface,
            states: $($states)*,
        }),*];
    };
}

/// Calls the macro `$make`, after the tokens `$first`, with a row for each function of FMI 2.0:
/// name, interface, states in brackets, type. `c_int`, `Pointer`, `Text`, `Callbacks` and `Logger`
/// must be in scope.
macro_rules! fmi2_functions {
    ($make:ident! $($first:tt)*) => {
        $make! {
            $($first)*
            fmi2GetTypesPlatform Shared [ANY] () -> Text;
            fmi2GetVersion Shared [ANY] () -> Text;
            fmi2SetDebugLogging Shared [ANY] (Pointer, c_int, usize, *const Text) -> c_int;
            fmi2Instantiate Shared [ANY] (Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Pointer;
            fmi2FreeInstance Shared [ANY] (Pointer);
            fmi2SetupExperiment Shared [INSTANTIATED] (Pointer, c_int, f64, f64, c_int, f64) -> c_int;
            fmi2EnterInitializationMode Shared [INSTANTIATED] (Pointer) -> c_int;
            fmi2ExitInitializationMode Shared [INITIALIZATION_MODE] (Pointer) -> c_int;
            fmi2Terminate Shared [STEP_MODE] (Pointer) -> c_int;
            fmi2Reset Shared [ANY] (Pointer) -> c_int;
            fmi2GetReal Shared [GET_2] (Pointer, *const u32, usize, *mut f64) -> c_int;
            fmi2GetInteger Shared [GET_2] (Pointer, *const u32, usize, *mut c_int) -> c_int;
            fmi2GetBoolean Shared [GET_2] (Pointer, *const u32, usize, *mut c_int) -> c_int;
            fmi2GetString Shared [GET_2] (Pointer, *const u32, usize, *mut Text) -> c_int;
            fmi2SetReal Shared [SET_2] (Pointer, *const u32, usize, *const f64) -> c_int;
            fmi2SetInteger Shared [SET_2] (Pointer, *const u32, usize, *const c_int) -> c_int;
            fmi2SetBoolean Shared [SET_2] (Pointer, *const u32, usize, *const c_int) -> c_int;
            fmi2SetString Shared [SET_2] (Pointer, *const u32, usize, *const Text) -> c_int;
            fmi2GetFMUstate Shared [ANY] (Pointer, *mut Pointer) -> c_int;
            fmi2SetFMUstate Shared [ANY] (Pointer, Pointer) -> c_int;
            fmi2FreeFMUstate Shared [ANY] (Pointer, *mut Pointer) -> c_int;
            fmi2SerializedFMUstateSize Shared [ANY] (Pointer, Pointer, *mut usize) -> c_int;
            fmi2SerializeFMUstate Shared [ANY] (Pointer, Pointer, *mut u8, usize) -> c_int;
            fmi2DeSerializeFMUstate Shared [ANY] (Pointer, *const u8, usize, *mut Pointer) -> c_int;
            fmi2GetDirectionalDerivative Shared [GET_2]
                (Pointer, *const u32, usize, *const u32, usize, *const f64, *mut f64) -> c_int;
            fmi2SetRealInputDerivatives CoSimulation [SET_2]
                (Pointer, *const u32, usize, *const c_int, *const f64) -> c_int;
            fmi2GetRealOutputDerivatives CoSimulation [STEP_MODE | TERMINATED]
                (Pointer, *const u32, usize, *const c_int, *mut f64) -> c_int;
            fmi2DoStep CoSimulation [STEP_MODE] (Pointer, f64, f64, c_int) -> c_int;
            fmi2CancelStep CoSimulation [ANY] (Pointer) -> c_int;
            fmi2GetStatus CoSimulation [STEP_MODE | TERMINATED] (Pointer, c_int, *mut c_int) -> c_int;
            fmi2GetRealStatus CoSimulation [STEP_MODE | TERMINATED] (Pointer, c_int, *mut f64) -> c_int;
            fmi2GetIntegerStatus CoSimulation [STEP_MODE | TERMINATED] (Pointer, c_int, *mut c_int) -> c_int;
            fmi2GetBooleanStatus CoSimulation [STEP_MODE | TERMINATED] (Pointer, c_int, *mut c_int) -> c_int;
            fmi2GetStringStatus CoSimulation [STEP_MODE | TERMINATED] (Pointer, c_int, *mut Text) -> c_int;
            fmi2EnterEventMode ModelExchange [NONE] (Pointer) -> c_int;
            fmi2NewDiscreteStates ModelExchange [NONE] (Pointer, Pointer) -> c_int;
            fmi2EnterContinuousTimeMode ModelExchange [NONE] (Pointer) -> c_int;
            fmi2CompletedIntegratorStep ModelExchange [NONE] (Pointer, c_int, *mut c_int, *mut c_int) -> c_int;
            fmi2SetTime ModelExchange [NONE] (Pointer, f64) -> c_int;
            fmi2SetContinuousStates ModelExchange [NONE] (Pointer, *const f64, usize) -> c_int;
            fmi2GetDerivatives ModelExchange [NONE] (Pointer, *mut f64, usize) -> c_int;
            fmi2GetEventIndicators ModelExchange [NONE] (Pointer, *mut f64, usize) -> c_int;
            fmi2GetContinuousStates ModelExchange [NONE] (Pointer, *mut f64, usize) -> c_int;
            fmi2GetNominalsOfContinuousStates ModelExchange [NONE] (Pointer, *mut f64, usize) -> c_int;
        }
    };
}

/// As `fmi2_functions`, with the functions of FMI 3.0; also for programs that offer these functions
/// themselves.
#[macro_export]
macro_rules! fmi3_functions {
    ($make:ident! $($first:tt)*) => {
        $make! {
            $($first)*
            fmi3GetVersion Shared [GET_3] () -> Text;
            fmi3SetDebugLogging Shared [ANY] (Pointer, bool, usize, *const Text) -> c_int;
            fmi3InstantiateModelExchange ModelExchange [ANY]
                (Text, Text, Text, bool, bool, Pointer, Option<Logger>) -> Pointer;
            fmi3InstantiateCoSimulation CoSimulation [ANY]
                (Text, Text, Text, bool, bool, bool, bool, *const u32, usize, Pointer, Option<Logger>, Pointer) -> Pointer;
            fmi3InstantiateScheduledExecution ScheduledExecution [ANY]
                (Text, Text, Text, bool, bool, Pointer, Option<Logger>, Pointer, Pointer, Pointer) -> Pointer;
            fmi3FreeInstance Shared [ANY] (Pointer);
            fmi3EnterInitializationMode Shared [INSTANTIATED] (Pointer, bool, f64, f64, bool, f64) -> c_int;
            fmi3ExitInitializationMode Shared [INITIALIZATION_MODE] (Pointer) -> c_int;
            fmi3EnterEventMode Shared [STEP_MODE | AFTER_SET] (Pointer) -> c_int;
            fmi3Terminate Shared [EVENT_MODE | STEP_MODE | AFTER_SET] (Pointer) -> c_int;
            fmi3Reset Shared [ANY] (Pointer) -> c_int;
            fmi3GetFloat32 Shared [GET_3] (Pointer, *const u32, usize, *mut f32, usize) -> c_int;
            fmi3GetFloat64 Shared [GET_3] (Pointer, *const u32, usize, *mut f64, usize) -> c_int;
            fmi3GetInt8 Shared [GET_3] (Pointer, *const u32, usize, *mut i8, usize) -> c_int;
            fmi3GetUInt8 Shared [GET_3] (Pointer, *const u32, usize, *mut u8, usize) -> c_int;
            fmi3GetInt16 Shared [GET_3] (Pointer, *const u32, usize, *mut i16, usize) -> c_int;
            fmi3GetUInt16 Shared [GET_3] (Pointer, *const u32, usize, *mut u16, usize) -> c_int;
            fmi3GetInt32 Shared [GET_3] (Pointer, *const u32, usize, *mut i32, usize) -> c_int;
            fmi3GetUInt32 Shared [GET_3] (Pointer, *const u32, usize, *mut u32, usize) -> c_int;
            fmi3GetInt64 Shared [GET_3] (Pointer, *const u32, usize, *mut i64, usize) -> c_int;
            fmi3GetUInt64 Shared [GET_3] (Pointer, *const u32, usize, *mut u64, usize) -> c_int;
            fmi3GetBoolean Shared [GET_3] (Pointer, *const u32, usize, *mut bool, usize) -> c_int;
            fmi3GetString Shared [GET_3] (Pointer, *const u32, usize, *mut Text, usize) -> c_int;
            fmi3GetBinary Shared [GET_3]
                (Pointer, *const u32, usize, *mut usize, *mut *const u8, usize) -> c_int;
            fmi3GetClock Shared [EVENT_MODE] (Pointer, *const u32, usize, *mut bool) -> c_int;
            fmi3SetFloat32 Shared [SET_3] (Pointer, *const u32, usize, *const f32, usize) -> c_int;
            fmi3SetFloat64 Shared [SET_3] (Pointer, *const u32, usize, *const f64, usize) -> c_int;
            fmi3SetInt8 Shared [SET_3] (Pointer, *const u32, usize, *const i8, usize) -> c_int;
            fmi3SetUInt8 Shared [SET_3] (Pointer, *const u32, usize, *const u8, usize) -> c_int;
            fmi3SetInt16 Shared [SET_3] (Pointer, *const u32, usize, *const i16, usize) -> c_int;
            fmi3SetUInt16 Shared [SET_3] (Pointer, *const u32, usize, *const u16, usize) -> c_int;
            fmi3SetInt32 Shared [SET_3] (Pointer, *const u32, usize, *const i32, usize) -> c_int;
            fmi3SetUInt32 Shared [SET_3] (Pointer, *const u32, usize, *const u32, usize) -> c_int;
            fmi3SetInt64 Shared [SET_3] (Pointer, *const u32, usize, *const i64, usize) -> c_int;
            fmi3SetUInt64 Shared [SET_3] (Pointer, *const u32, usize, *const u64, usize) -> c_int;
            fmi3SetBoolean Shared [SET_3] (Pointer, *const u32, usize, *const bool, usize) -> c_int;
            fmi3SetString Shared [SET_3] (Pointer, *const u32, usize, *const Text, usize) -> c_int;
            fmi3SetBinary Shared [SET_3]
                (Pointer, *const u32, usize, *const usize, *const *const u8, usize) -> c_int;
            fmi3SetClock Shared [EVENT_MODE] (Pointer, *const u32, usize, *const bool) -> c_int;
            fmi3GetNumberOfVariableDependencies Shared [ANY] (Pointer, u32, *mut usize) -> c_int;
            fmi3GetVariableDependencies Shared [ANY]
                (Pointer, u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize) -> c_int;
            fmi3GetFMUState Shared [ANY] (Pointer, *mut Pointer) -> c_int;
            fmi3SetFMUState Shared [ANY] (Pointer, Pointer) -> c_int;
            fmi3FreeFMUState Shared [ANY] (Pointer, *mut Pointer) -> c_int;
            fmi3SerializedFMUStateSize Shared [ANY] (Pointer, Pointer, *mut usize) -> c_int;
            fmi3SerializeFMUState Shared [ANY] (Pointer, Pointer, *mut u8, usize) -> c_int;
            fmi3DeserializeFMUState Shared [ANY] (Pointer, *const u8, usize, *mut Pointer) -> c_int;
            fmi3GetDirectionalDerivative Shared [INITIALIZATION_MODE | EVENT_MODE | STEP_MODE | AFTER_SET | TERMINATED]
                (Pointer, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
            fmi3GetAdjointDerivative Shared [INITIALIZATION_MODE | EVENT_MODE | STEP_MODE | AFTER_SET | TERMINATED]
                (Pointer, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
            fmi3EnterConfigurationMode Shared [INSTANTIATED | STEP_MODE | AFTER_SET] (Pointer) -> c_int;
            fmi3ExitConfigurationMode Shared [ANY] (Pointer) -> c_int;
            fmi3GetIntervalDecimal Shared [INITIALIZATION_MODE | EVENT_MODE] (Pointer, *const u32, usize, *mut f64, *mut c_int) -> c_int;
            fmi3GetIntervalFraction Shared [INITIALIZATION_MODE | EVENT_MODE]
                (Pointer, *const u32, usize, *mut u64, *mut u64, *mut c_int) -> c_int;
            fmi3GetShiftDecimal Shared [INITIALIZATION_MODE] (Pointer, *const u32, usize, *mut f64) -> c_int;
            fmi3GetShiftFraction Shared [INITIALIZATION_MODE] (Pointer, *const u32, usize, *mut u64, *mut u64) -> c_int;
            fmi3SetIntervalDecimal Shared [INITIALIZATION_MODE | EVENT_MODE] (Pointer, *const u32, usize, *const f64) -> c_int;
            fmi3SetIntervalFraction Shared [INITIALIZATION_MODE | EVENT_MODE] (Pointer, *const u32, usize, *const u64, *const u64) -> c_int;
            fmi3SetShiftDecimal Shared [INITIALIZATION_MODE | EVENT_MODE] (Pointer, *const u32, usize, *const f64) -> c_int;
            fmi3SetShiftFraction Shared [INITIALIZATION_MODE | EVENT_MODE] (Pointer, *const u32, usize, *const u64, *const u64) -> c_int;
            fmi3EvaluateDiscreteStates Shared [EVENT_MODE] (Pointer) -> c_int;
            fmi3UpdateDiscreteStates Shared [EVENT_MODE]
                (Pointer, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
            fmi3EnterStepMode CoSimulation [EVENT_MODE] (Pointer) -> c_int;
            fmi3GetOutputDerivatives CoSimulation [STEP_MODE | TERMINATED]
                (Pointer, *const u32, usize, *const c_int, *mut f64, usize) -> c_int;
            fmi3DoStep CoSimulation [STEP_MODE | AFTER_SET]
                (Pointer, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
            fmi3EnterContinuousTimeMode ModelExchange [NONE] (Pointer) -> c_int;
            fmi3CompletedIntegratorStep ModelExchange [NONE] (Pointer, bool, *mut bool, *mut bool) -> c_int;
            fmi3SetTime ModelExchange [NONE] (Pointer, f64) -> c_int;
            fmi3SetContinuousStates ModelExchange [NONE] (Pointer, *const f64, usize) -> c_int;
            fmi3GetContinuousStateDerivatives ModelExchange [NONE] (Pointer, *mut f64, usize) -> c_int;
            fmi3GetEventIndicators ModelExchange [NONE] (Pointer, *mut f64, usize) -> c_int;
            fmi3GetContinuousStates ModelExchange [NONE] (Pointer, *mut f64, usize) -> c_int;
            fmi3GetNominalsOfContinuousStates ModelExchange [NONE] (Pointer, *mut f64, usize) -> c_int;
            fmi3GetNumberOfEventIndicators ModelExchange [NONE] (Pointer, *mut usize) -> c_int;
            fmi3GetNumberOfContinuousStates ModelExchange [NONE] (Pointer, *mut usize) -> c_int;
            fmi3ActivateModelPartition ScheduledExecution [NONE] (Pointer, u32, f64) -> c_int;
        }
    };
}

fmi2_functions!(list! FMI2);
fmi3_functions!(list! FMI3);
pub(crate) use {fmi2_functions, fmi3_functions};

#[cfg(test)]
mod tests {
    use super::*;

    /// The state machine of FMI 2.0.4, section 4.2.4, spelt out for each state: what may be called
    /// of what is not allowed always.
    #[test]
    fn the_table_is_that_of_the_standard() {
        let only = |mode, expected: &[&str]| {
            let sometimes = [
                "fmi2SetupExperiment",
                "fmi2EnterInitializationMode",
                "fmi2ExitInitializationMode",
                "fmi2DoStep",
                "fmi2Terminate",
                "fmi2GetReal",
                "fmi2SetReal",
                "fmi2GetStatus",
                "fmi2GetDirectionalDerivative",
            ];
            let is_allowed = |name: &str| Function::named(name).unwrap().is_allowed(mode);
            let allowed: Vec<_> = sometimes.into_iter().filter(|f| is_allowed(f)).collect();
            assert_eq!(allowed, expected, "{mode:?}");
            for always in ["fmi2Reset", "fmi2GetFMUstate", "fmi2SetDebugLogging"] {
                assert!(is_allowed(always), "{always} {mode:?}");
            }
        };
        only(
            Mode::Instantiated,
            &[
                "fmi2SetupExperiment",
                "fmi2EnterInitializationMode",
                "fmi2SetReal",
            ],
        );
        only(
            Mode::Initialization,
            &[
                "fmi2ExitInitializationMode",
                "fmi2GetReal",
                "fmi2SetReal",
                "fmi2GetDirectionalDerivative",
            ],
        );
        only(
            Mode::Stepping,
            &[
                "fmi2DoStep",
                "fmi2Terminate",
                "fmi2GetReal",
                "fmi2SetReal",
                "fmi2GetStatus",
                "fmi2GetDirectionalDerivative",
            ],
        );
        only(
            Mode::Terminated,
            &[
                "fmi2GetReal",
                "fmi2GetStatus",
                "fmi2GetDirectionalDerivative",
            ],
        );
    }

    /// Counted in the headers of the standard: of 2.0 25 functions that both interfaces share, 9 of
    /// co-simulation, 10 of model exchange; of 3.0 58 that all share, 4, 11 and 2.
    #[test]
    fn the_lists_are_complete() {
        use Interface::{CoSimulation, ModelExchange, ScheduledExecution, Shared};
        let count =
            |list: &[Function], interface| list.iter().filter(|f| f.interface == interface).count();
        let all = [Shared, CoSimulation, ModelExchange, ScheduledExecution];
        assert_eq!(all.map(|interface| count(FMI2, interface)), [25, 9, 10, 0]);
        assert_eq!(all.map(|interface| count(FMI3, interface)), [58, 4, 11, 2]);
    }
}
