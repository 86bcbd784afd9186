//! Call order: in which state of an instance each function is allowed (FMI 2.0.4, section 4.2.4).
//!
//! Departures, all on the strict side but one: fmi2GetDirectionalDerivative is refused in Initialization Mode, where outputs
//! depend on inputs through the initialization too; fmi2SetupExperiment may be left out (start time 0).

use crate::failure::Failure;
use serde::{Deserialize, Serialize};

/// State of an instance. A discarded step leaves it in `StepComplete`, as it was before the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub(crate) enum Mode {
    Instantiated = 1,
    Initialization = 2,
    StepComplete = 4,
    Terminated = 8,
}

impl Mode {
    const ALL: [(Mode, &str); 4] = [
        (Mode::Instantiated, "Instantiated"),
        (Mode::Initialization, "Initialization Mode"),
        (Mode::StepComplete, "Step Complete"),
        (Mode::Terminated, "Terminated"),
    ];
}

const I: u8 = Mode::Instantiated as u8;
const N: u8 = Mode::Initialization as u8;
const S: u8 = Mode::StepComplete as u8;
const T: u8 = Mode::Terminated as u8;

/// A function and the states it is allowed in.
#[derive(Clone, Copy)]
pub(crate) struct Call {
    pub(crate) name: &'static str,
    allowed: u8,
}

impl Call {
    /// Refuses the call in a state it is not allowed in.
    #[inline]
    pub(crate) fn check(self, mode: Mode) -> Result<(), Failure> {
        if self.allowed & mode as u8 != 0 {
            Ok(())
        } else {
            Err(self.out_of_order(mode))
        }
    }

    #[cold]
    fn out_of_order(self, mode: Mode) -> Failure {
        let names = |mask: u8| -> Vec<&str> {
            Mode::ALL
                .iter()
                .filter(|(m, _)| mask & *m as u8 != 0)
                .map(|(_, name)| *name)
                .collect()
        };
        let (now, allowed) = (names(mode as u8).join(""), names(self.allowed).join(", "));
        Failure::Error(format!("not allowed in state {now}; allowed in {allowed}"))
    }
}

macro_rules! calls {
    ($($constant:ident $name:literal $allowed:expr;)*) => {
        $(pub(crate) const $constant: Call = Call { name: $name, allowed: $allowed };)*
    };
}

calls! {
    SET_DEBUG_LOGGING          "fmi2SetDebugLogging"          I | N | S | T;
    SETUP_EXPERIMENT           "fmi2SetupExperiment"          I;
    ENTER_INITIALIZATION_MODE  "fmi2EnterInitializationMode"  I;
    EXIT_INITIALIZATION_MODE   "fmi2ExitInitializationMode"   N;
    TERMINATE                  "fmi2Terminate"                S;
    RESET                      "fmi2Reset"                    I | N | S | T;
    GET_REAL                   "fmi2GetReal"                  N | S | T;
    GET_INTEGER                "fmi2GetInteger"               N | S | T;
    GET_BOOLEAN                "fmi2GetBoolean"               N | S | T;
    GET_STRING                 "fmi2GetString"                N | S | T;
    SET_REAL                   "fmi2SetReal"                  I | N | S;
    SET_INTEGER                "fmi2SetInteger"               I | N | S;
    SET_BOOLEAN                "fmi2SetBoolean"               I | N | S;
    SET_STRING                 "fmi2SetString"                I | N | S;
    GET_FMU_STATE              "fmi2GetFMUstate"              I | N | S | T;
    SET_FMU_STATE              "fmi2SetFMUstate"              I | N | S | T;
    FREE_FMU_STATE             "fmi2FreeFMUstate"             I | N | S | T;
    SERIALIZED_FMU_STATE_SIZE  "fmi2SerializedFMUstateSize"   I | N | S | T;
    SERIALIZE_FMU_STATE        "fmi2SerializeFMUstate"        I | N | S | T;
    DESERIALIZE_FMU_STATE      "fmi2DeSerializeFMUstate"      I | N | S | T;
    GET_DIRECTIONAL_DERIVATIVE "fmi2GetDirectionalDerivative" S | T;
    SET_INPUT_DERIVATIVES      "fmi2SetRealInputDerivatives"  I | N | S;
    GET_OUTPUT_DERIVATIVES     "fmi2GetRealOutputDerivatives" S | T;
    DO_STEP                    "fmi2DoStep"                   S;
    CANCEL_STEP                "fmi2CancelStep"               I | N | S | T;
    GET_STATUS                 "fmi2GetStatus"                S | T;
    GET_REAL_STATUS            "fmi2GetRealStatus"            S | T;
    GET_INTEGER_STATUS         "fmi2GetIntegerStatus"         S | T;
    GET_BOOLEAN_STATUS         "fmi2GetBooleanStatus"         S | T;
    GET_STRING_STATUS          "fmi2GetStringStatus"          S | T;
}
