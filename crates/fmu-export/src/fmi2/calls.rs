//! Call order: in which state of an instance each function is allowed (FMI 2.0.4, section 4.2.4).
//!
//! Departures: fmi2SetupExperiment may be left out (start time 0), and what is set at a communication point can be read back there
//! before the next step.

use crate::border::call::{Call, I, L, N, S, T, calls};

/// Names of the states.
pub(crate) const STATES: [(u8, &str); 5] = [
    (I, "Instantiated"),
    (N, "Initialization Mode"),
    (S, "Step Complete"),
    (T, "Terminated"),
    (L, "lost by a panic"),
];

calls! {
    SET_DEBUG_LOGGING          "fmi2SetDebugLogging"          I | N | S | T | L;
    SETUP_EXPERIMENT           "fmi2SetupExperiment"          I;
    ENTER_INITIALIZATION_MODE  "fmi2EnterInitializationMode"  I;
    EXIT_INITIALIZATION_MODE   "fmi2ExitInitializationMode"   N;
    TERMINATE                  "fmi2Terminate"                S | L;
    RESET                      "fmi2Reset"                    I | N | S | T | L;
    GET_REAL                   "fmi2GetReal"                  N | S | T;
    GET_INTEGER                "fmi2GetInteger"               N | S | T;
    GET_BOOLEAN                "fmi2GetBoolean"               N | S | T;
    GET_STRING                 "fmi2GetString"                N | S | T;
    SET_REAL                   "fmi2SetReal"                  I | N | S;
    SET_INTEGER                "fmi2SetInteger"               I | N | S;
    SET_BOOLEAN                "fmi2SetBoolean"               I | N | S;
    SET_STRING                 "fmi2SetString"                I | N | S;
    GET_FMU_STATE              "fmi2GetFMUstate"              I | N | S | T;
    SET_FMU_STATE              "fmi2SetFMUstate"              I | N | S | T | L;
    FREE_FMU_STATE             "fmi2FreeFMUstate"             I | N | S | T | L;
    SERIALIZED_FMU_STATE_SIZE  "fmi2SerializedFMUstateSize"   I | N | S | T | L;
    SERIALIZE_FMU_STATE        "fmi2SerializeFMUstate"        I | N | S | T | L;
    DESERIALIZE_FMU_STATE      "fmi2DeSerializeFMUstate"      I | N | S | T | L;
    GET_DIRECTIONAL_DERIVATIVE "fmi2GetDirectionalDerivative" N | S | T;
    SET_INPUT_DERIVATIVES      "fmi2SetRealInputDerivatives"  I | N | S;
    GET_OUTPUT_DERIVATIVES     "fmi2GetRealOutputDerivatives" S | T;
    DO_STEP                    "fmi2DoStep"                   S;
    CANCEL_STEP                "fmi2CancelStep"               I | N | S | T;
    GET_STATUS                 "fmi2GetStatus"                S | T | L;
    GET_REAL_STATUS            "fmi2GetRealStatus"            S | T | L;
    GET_INTEGER_STATUS         "fmi2GetIntegerStatus"         S | T | L;
    GET_BOOLEAN_STATUS         "fmi2GetBooleanStatus"         S | T | L;
    GET_STRING_STATUS          "fmi2GetStringStatus"          S | T | L;
}
