//! The call order for co-simulation.

/// States of FMI 2.0.4, section 4.2.4, and of FMI 3.0.1, section 4.2.1.
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
}

const INSTANTIATED: u8 = 1;
const INITIALIZATION: u8 = 2;
const STEPPING: u8 = 4;
const TERMINATED: u8 = 8;
const EVENT: u8 = 16;
const AFTER_SET: u8 = 32;
const ALL: u8 = 63;

/// The state machines as a table: in which states a function of an FMU without clocks and
/// structural parameters may be called.
pub fn is_allowed(name: &str, mode: Mode) -> bool {
    let allowed = match name.strip_prefix("fmi3") {
        Some(name) => allowed_3(name),
        None => allowed_2(name),
    };
    let bit = match mode {
        Mode::Instantiated => INSTANTIATED,
        Mode::Initialization => INITIALIZATION,
        Mode::Event => EVENT,
        Mode::Stepping => STEPPING,
        Mode::SteppingAfterSet => AFTER_SET,
        Mode::Terminated => TERMINATED,
    };
    allowed & bit != 0
}

/// FMI 3.0.1, sections 2.3 and 4.2.1.
fn allowed_3(name: &str) -> u8 {
    match name {
        "EnterInitializationMode" => INSTANTIATED,
        "ExitInitializationMode" => INITIALIZATION,
        "EnterEventMode" | "DoStep" => STEPPING | AFTER_SET,
        "EnterStepMode" | "UpdateDiscreteStates" | "EvaluateDiscreteStates" => EVENT,
        "Terminate" => EVENT | STEPPING | AFTER_SET,
        "EnterConfigurationMode" => INSTANTIATED | STEPPING | AFTER_SET,
        "GetClock" | "SetClock" => EVENT,
        "GetShiftDecimal" | "GetShiftFraction" => INITIALIZATION,
        name if name.contains("Interval") || name.contains("Shift") => INITIALIZATION | EVENT,
        "GetDirectionalDerivative" | "GetAdjointDerivative" => {
            INITIALIZATION | EVENT | STEPPING | AFTER_SET | TERMINATED
        }
        "GetOutputDerivatives" => STEPPING | TERMINATED,
        name if name.contains("FMUState") || name.contains("Dependencies") => ALL,
        name if name.starts_with("Get") => ALL & !AFTER_SET,
        "SetDebugLogging" => ALL,
        name if name.starts_with("Set") => ALL & !TERMINATED,
        _ => ALL,
    }
}

/// FMI 2.0.4, section 4.2.4.
fn allowed_2(name: &str) -> u8 {
    match name {
        "fmi2SetupExperiment" | "fmi2EnterInitializationMode" => INSTANTIATED,
        "fmi2ExitInitializationMode" => INITIALIZATION,
        "fmi2Terminate" | "fmi2DoStep" => STEPPING,
        "fmi2GetReal" | "fmi2GetInteger" | "fmi2GetBoolean" | "fmi2GetString" => {
            INITIALIZATION | STEPPING | TERMINATED
        }
        "fmi2SetReal"
        | "fmi2SetInteger"
        | "fmi2SetBoolean"
        | "fmi2SetString"
        | "fmi2SetRealInputDerivatives" => INSTANTIATED | INITIALIZATION | STEPPING,
        "fmi2GetDirectionalDerivative" => INITIALIZATION | STEPPING | TERMINATED,
        "fmi2GetRealOutputDerivatives"
        | "fmi2GetStatus"
        | "fmi2GetRealStatus"
        | "fmi2GetIntegerStatus"
        | "fmi2GetBooleanStatus"
        | "fmi2GetStringStatus" => STEPPING | TERMINATED,
        _ => ALL,
    }
}

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
            let allowed: Vec<_> = sometimes
                .into_iter()
                .filter(|f| is_allowed(f, mode))
                .collect();
            assert_eq!(allowed, expected, "{mode:?}");
            for always in ["fmi2Reset", "fmi2GetFMUstate", "fmi2SetDebugLogging"] {
                assert!(is_allowed(always, mode), "{always} {mode:?}");
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
}
