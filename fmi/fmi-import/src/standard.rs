//! The C functions of FMI 2.0 and 3.0: name, interface, when an importer that does co-simulation
//! may call them, and C type. Enumerations are plain integers here: what a broken FMU returns must
//! not be undefined behaviour in the one who calls it.
//!
//! [`fmi2_functions`](crate::fmi2_functions) and [`fmi3_functions`](crate::fmi3_functions) hand the
//! rows to another macro. Where they are used, `c_int`, `Pointer`, `Text`, and `Callbacks` and
//! `Logger` of [`calls`](crate::calls) must be in scope.

use std::ffi::{c_char, c_void};

/// An instance, a saved state, an environment.
pub type Pointer = *mut c_void;
/// A C string.
pub type Text = *const c_char;

/// A function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name.
    pub name: &'static str,
    /// Who has it.
    pub interface: Interface,
    /// Bits of the states in which it may be called.
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
    /// The same in FMI 3.0 after something was set: nothing may be read before the next step.
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

// The states in the lists below.
const N: u8 = Mode::Instantiated.bit();
const I: u8 = Mode::Initialization.bit();
const E: u8 = Mode::Event.bit();
const S: u8 = Mode::Stepping.bit();
const A: u8 = Mode::SteppingAfterSet.bit();
const T: u8 = Mode::Terminated.bit();
const ANY: u8 = N | I | E | S | A | T;
/// Not in co-simulation.
const NO: u8 = 0;

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
/// name, interface, states in brackets, type.
#[macro_export]
macro_rules! fmi2_functions {
    ($make:ident! $($first:tt)*) => {
        $make! {
            $($first)*
            fmi2GetTypesPlatform Shared [ANY] () -> Text;
            fmi2GetVersion Shared [ANY] () -> Text;
            fmi2SetDebugLogging Shared [ANY] (Pointer, c_int, usize, *const Text) -> c_int;
            fmi2Instantiate Shared [ANY] (Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Pointer;
            fmi2FreeInstance Shared [ANY] (Pointer);
            fmi2SetupExperiment Shared [N] (Pointer, c_int, f64, f64, c_int, f64) -> c_int;
            fmi2EnterInitializationMode Shared [N] (Pointer) -> c_int;
            fmi2ExitInitializationMode Shared [I] (Pointer) -> c_int;
            fmi2Terminate Shared [S] (Pointer) -> c_int;
            fmi2Reset Shared [ANY] (Pointer) -> c_int;
            fmi2GetReal Shared [I | S | T] (Pointer, *const u32, usize, *mut f64) -> c_int;
            fmi2GetInteger Shared [I | S | T] (Pointer, *const u32, usize, *mut c_int) -> c_int;
            fmi2GetBoolean Shared [I | S | T] (Pointer, *const u32, usize, *mut c_int) -> c_int;
            fmi2GetString Shared [I | S | T] (Pointer, *const u32, usize, *mut Text) -> c_int;
            fmi2SetReal Shared [N | I | S] (Pointer, *const u32, usize, *const f64) -> c_int;
            fmi2SetInteger Shared [N | I | S] (Pointer, *const u32, usize, *const c_int) -> c_int;
            fmi2SetBoolean Shared [N | I | S] (Pointer, *const u32, usize, *const c_int) -> c_int;
            fmi2SetString Shared [N | I | S] (Pointer, *const u32, usize, *const Text) -> c_int;
            fmi2GetFMUstate Shared [ANY] (Pointer, *mut Pointer) -> c_int;
            fmi2SetFMUstate Shared [ANY] (Pointer, Pointer) -> c_int;
            fmi2FreeFMUstate Shared [ANY] (Pointer, *mut Pointer) -> c_int;
            fmi2SerializedFMUstateSize Shared [ANY] (Pointer, Pointer, *mut usize) -> c_int;
            fmi2SerializeFMUstate Shared [ANY] (Pointer, Pointer, *mut u8, usize) -> c_int;
            fmi2DeSerializeFMUstate Shared [ANY] (Pointer, *const u8, usize, *mut Pointer) -> c_int;
            fmi2GetDirectionalDerivative Shared [I | S | T]
                (Pointer, *const u32, usize, *const u32, usize, *const f64, *mut f64) -> c_int;
            fmi2SetRealInputDerivatives CoSimulation [N | I | S]
                (Pointer, *const u32, usize, *const c_int, *const f64) -> c_int;
            fmi2GetRealOutputDerivatives CoSimulation [S | T]
                (Pointer, *const u32, usize, *const c_int, *mut f64) -> c_int;
            fmi2DoStep CoSimulation [S] (Pointer, f64, f64, c_int) -> c_int;
            fmi2CancelStep CoSimulation [ANY] (Pointer) -> c_int;
            fmi2GetStatus CoSimulation [S | T] (Pointer, c_int, *mut c_int) -> c_int;
            fmi2GetRealStatus CoSimulation [S | T] (Pointer, c_int, *mut f64) -> c_int;
            fmi2GetIntegerStatus CoSimulation [S | T] (Pointer, c_int, *mut c_int) -> c_int;
            fmi2GetBooleanStatus CoSimulation [S | T] (Pointer, c_int, *mut c_int) -> c_int;
            fmi2GetStringStatus CoSimulation [S | T] (Pointer, c_int, *mut Text) -> c_int;
            fmi2EnterEventMode ModelExchange [NO] (Pointer) -> c_int;
            fmi2NewDiscreteStates ModelExchange [NO] (Pointer, Pointer) -> c_int;
            fmi2EnterContinuousTimeMode ModelExchange [NO] (Pointer) -> c_int;
            fmi2CompletedIntegratorStep ModelExchange [NO] (Pointer, c_int, *mut c_int, *mut c_int) -> c_int;
            fmi2SetTime ModelExchange [NO] (Pointer, f64) -> c_int;
            fmi2SetContinuousStates ModelExchange [NO] (Pointer, *const f64, usize) -> c_int;
            fmi2GetDerivatives ModelExchange [NO] (Pointer, *mut f64, usize) -> c_int;
            fmi2GetEventIndicators ModelExchange [NO] (Pointer, *mut f64, usize) -> c_int;
            fmi2GetContinuousStates ModelExchange [NO] (Pointer, *mut f64, usize) -> c_int;
            fmi2GetNominalsOfContinuousStates ModelExchange [NO] (Pointer, *mut f64, usize) -> c_int;
        }
    };
}

/// The same with the functions of FMI 3.0.
#[macro_export]
macro_rules! fmi3_functions {
    ($make:ident! $($first:tt)*) => {
        $make! {
            $($first)*
            fmi3GetVersion Shared [N | I | E | S | T] () -> Text;
            fmi3SetDebugLogging Shared [ANY] (Pointer, bool, usize, *const Text) -> c_int;
            fmi3InstantiateModelExchange ModelExchange [ANY]
                (Text, Text, Text, bool, bool, Pointer, Option<Logger>) -> Pointer;
            fmi3InstantiateCoSimulation CoSimulation [ANY]
                (Text, Text, Text, bool, bool, bool, bool, *const u32, usize, Pointer, Option<Logger>, Pointer) -> Pointer;
            fmi3InstantiateScheduledExecution ScheduledExecution [ANY]
                (Text, Text, Text, bool, bool, Pointer, Option<Logger>, Pointer, Pointer, Pointer) -> Pointer;
            fmi3FreeInstance Shared [ANY] (Pointer);
            fmi3EnterInitializationMode Shared [N] (Pointer, bool, f64, f64, bool, f64) -> c_int;
            fmi3ExitInitializationMode Shared [I] (Pointer) -> c_int;
            fmi3EnterEventMode Shared [S | A] (Pointer) -> c_int;
            fmi3Terminate Shared [E | S | A] (Pointer) -> c_int;
            fmi3Reset Shared [ANY] (Pointer) -> c_int;
            fmi3GetFloat32 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut f32, usize) -> c_int;
            fmi3GetFloat64 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut f64, usize) -> c_int;
            fmi3GetInt8 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut i8, usize) -> c_int;
            fmi3GetUInt8 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut u8, usize) -> c_int;
            fmi3GetInt16 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut i16, usize) -> c_int;
            fmi3GetUInt16 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut u16, usize) -> c_int;
            fmi3GetInt32 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut i32, usize) -> c_int;
            fmi3GetUInt32 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut u32, usize) -> c_int;
            fmi3GetInt64 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut i64, usize) -> c_int;
            fmi3GetUInt64 Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut u64, usize) -> c_int;
            fmi3GetBoolean Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut bool, usize) -> c_int;
            fmi3GetString Shared [N | I | E | S | T] (Pointer, *const u32, usize, *mut Text, usize) -> c_int;
            fmi3GetBinary Shared [N | I | E | S | T]
                (Pointer, *const u32, usize, *mut usize, *mut *const u8, usize) -> c_int;
            fmi3GetClock Shared [E] (Pointer, *const u32, usize, *mut bool) -> c_int;
            fmi3SetFloat32 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const f32, usize) -> c_int;
            fmi3SetFloat64 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const f64, usize) -> c_int;
            fmi3SetInt8 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const i8, usize) -> c_int;
            fmi3SetUInt8 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const u8, usize) -> c_int;
            fmi3SetInt16 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const i16, usize) -> c_int;
            fmi3SetUInt16 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const u16, usize) -> c_int;
            fmi3SetInt32 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const i32, usize) -> c_int;
            fmi3SetUInt32 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const u32, usize) -> c_int;
            fmi3SetInt64 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const i64, usize) -> c_int;
            fmi3SetUInt64 Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const u64, usize) -> c_int;
            fmi3SetBoolean Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const bool, usize) -> c_int;
            fmi3SetString Shared [N | I | E | S | A] (Pointer, *const u32, usize, *const Text, usize) -> c_int;
            fmi3SetBinary Shared [N | I | E | S | A]
                (Pointer, *const u32, usize, *const usize, *const *const u8, usize) -> c_int;
            fmi3SetClock Shared [E] (Pointer, *const u32, usize, *const bool) -> c_int;
            fmi3GetNumberOfVariableDependencies Shared [ANY] (Pointer, u32, *mut usize) -> c_int;
            fmi3GetVariableDependencies Shared [ANY]
                (Pointer, u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize) -> c_int;
            fmi3GetFMUState Shared [ANY] (Pointer, *mut Pointer) -> c_int;
            fmi3SetFMUState Shared [ANY] (Pointer, Pointer) -> c_int;
            fmi3FreeFMUState Shared [ANY] (Pointer, *mut Pointer) -> c_int;
            fmi3SerializedFMUStateSize Shared [ANY] (Pointer, Pointer, *mut usize) -> c_int;
            fmi3SerializeFMUState Shared [ANY] (Pointer, Pointer, *mut u8, usize) -> c_int;
            fmi3DeserializeFMUState Shared [ANY] (Pointer, *const u8, usize, *mut Pointer) -> c_int;
            fmi3GetDirectionalDerivative Shared [I | E | S | A | T]
                (Pointer, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
            fmi3GetAdjointDerivative Shared [I | E | S | A | T]
                (Pointer, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
            fmi3EnterConfigurationMode Shared [N | S | A] (Pointer) -> c_int;
            fmi3ExitConfigurationMode Shared [ANY] (Pointer) -> c_int;
            fmi3GetIntervalDecimal Shared [I | E] (Pointer, *const u32, usize, *mut f64, *mut c_int) -> c_int;
            fmi3GetIntervalFraction Shared [I | E]
                (Pointer, *const u32, usize, *mut u64, *mut u64, *mut c_int) -> c_int;
            fmi3GetShiftDecimal Shared [I] (Pointer, *const u32, usize, *mut f64) -> c_int;
            fmi3GetShiftFraction Shared [I] (Pointer, *const u32, usize, *mut u64, *mut u64) -> c_int;
            fmi3SetIntervalDecimal Shared [I | E] (Pointer, *const u32, usize, *const f64) -> c_int;
            fmi3SetIntervalFraction Shared [I | E] (Pointer, *const u32, usize, *const u64, *const u64) -> c_int;
            fmi3SetShiftDecimal Shared [I | E] (Pointer, *const u32, usize, *const f64) -> c_int;
            fmi3SetShiftFraction Shared [I | E] (Pointer, *const u32, usize, *const u64, *const u64) -> c_int;
            fmi3EvaluateDiscreteStates Shared [E] (Pointer) -> c_int;
            fmi3UpdateDiscreteStates Shared [E]
                (Pointer, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
            fmi3EnterStepMode CoSimulation [E] (Pointer) -> c_int;
            fmi3GetOutputDerivatives CoSimulation [S | T]
                (Pointer, *const u32, usize, *const c_int, *mut f64, usize) -> c_int;
            fmi3DoStep CoSimulation [S | A]
                (Pointer, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
            fmi3EnterContinuousTimeMode ModelExchange [NO] (Pointer) -> c_int;
            fmi3CompletedIntegratorStep ModelExchange [NO] (Pointer, bool, *mut bool, *mut bool) -> c_int;
            fmi3SetTime ModelExchange [NO] (Pointer, f64) -> c_int;
            fmi3SetContinuousStates ModelExchange [NO] (Pointer, *const f64, usize) -> c_int;
            fmi3GetContinuousStateDerivatives ModelExchange [NO] (Pointer, *mut f64, usize) -> c_int;
            fmi3GetEventIndicators ModelExchange [NO] (Pointer, *mut f64, usize) -> c_int;
            fmi3GetContinuousStates ModelExchange [NO] (Pointer, *mut f64, usize) -> c_int;
            fmi3GetNominalsOfContinuousStates ModelExchange [NO] (Pointer, *mut f64, usize) -> c_int;
            fmi3GetNumberOfEventIndicators ModelExchange [NO] (Pointer, *mut usize) -> c_int;
            fmi3GetNumberOfContinuousStates ModelExchange [NO] (Pointer, *mut usize) -> c_int;
            fmi3ActivateModelPartition ScheduledExecution [NO] (Pointer, u32, f64) -> c_int;
        }
    };
}

fmi2_functions!(list! FMI2);
fmi3_functions!(list! FMI3);

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
