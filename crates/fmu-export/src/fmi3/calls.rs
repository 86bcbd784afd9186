//! Call order: in which state of an instance each function is allowed (FMI 3.0.2, sections 2.3 and 4.2.1), for a co-simulation FMU with
//! Event Mode, without clocks and structural parameters.

use crate::border::call::{Call, E, I, L, N, S, T, U, calls};

/// Step Mode, where values were set since the last step: nothing can be read before the next one (section 4.2.1). What must be exchanged
/// at a communication point goes through Event Mode.
pub(crate) const A: u8 = 128;

/// Names of the states.
pub(crate) const STATES: [(u8, &str); 8] = [
    (I, "Instantiated"),
    (N, "Initialization Mode"),
    (E, "Event Mode"),
    (S, "Step Mode"),
    (A, "Step Mode after a set"),
    (U, "Intermediate Update Mode"),
    (T, "Terminated"),
    (L, "lost by a panic"),
];

/// Every state but the callback within a step.
const ANY: u8 = I | N | E | S | A | T | L;

calls! {
    SET_DEBUG_LOGGING          "fmi3SetDebugLogging"          ANY;
    ENTER_INITIALIZATION_MODE  "fmi3EnterInitializationMode"  I;
    EXIT_INITIALIZATION_MODE   "fmi3ExitInitializationMode"   N;
    ENTER_EVENT_MODE           "fmi3EnterEventMode"           S | A;
    ENTER_STEP_MODE            "fmi3EnterStepMode"            E;
    EVALUATE_DISCRETE_STATES   "fmi3EvaluateDiscreteStates"   E;
    UPDATE_DISCRETE_STATES     "fmi3UpdateDiscreteStates"     E;
    DO_STEP                    "fmi3DoStep"                   S | A;
    LEAVE_UPDATE               "fmi3DoStep"                   U | L;
    TERMINATE                  "fmi3Terminate"                E | S | A | L;
    RESET                      "fmi3Reset"                    ANY;
    GET_FLOAT32                "fmi3GetFloat32"               I | N | E | S | U | T;
    GET_FLOAT64                "fmi3GetFloat64"               I | N | E | S | U | T;
    GET_INT8                   "fmi3GetInt8"                  I | N | E | S | U | T;
    GET_UINT8                  "fmi3GetUInt8"                 I | N | E | S | U | T;
    GET_INT16                  "fmi3GetInt16"                 I | N | E | S | U | T;
    GET_UINT16                 "fmi3GetUInt16"                I | N | E | S | U | T;
    GET_INT32                  "fmi3GetInt32"                 I | N | E | S | U | T;
    GET_UINT32                 "fmi3GetUInt32"                I | N | E | S | U | T;
    GET_INT64                  "fmi3GetInt64"                 I | N | E | S | U | T;
    GET_UINT64                 "fmi3GetUInt64"                I | N | E | S | U | T;
    GET_BOOLEAN                "fmi3GetBoolean"               I | N | E | S | U | T;
    GET_STRING                 "fmi3GetString"                I | N | E | S | U | T;
    GET_BINARY                 "fmi3GetBinary"                I | N | E | S | U | T;
    GET_CLOCK                  "fmi3GetClock"                 E;
    SET_FLOAT32                "fmi3SetFloat32"               I | N | E | S | A;
    SET_FLOAT64                "fmi3SetFloat64"               I | N | E | S | A;
    SET_INT8                   "fmi3SetInt8"                  I | N | E | S | A;
    SET_UINT8                  "fmi3SetUInt8"                 I | N | E | S | A;
    SET_INT16                  "fmi3SetInt16"                 I | N | E | S | A;
    SET_UINT16                 "fmi3SetUInt16"                I | N | E | S | A;
    SET_INT32                  "fmi3SetInt32"                 I | N | E | S | A;
    SET_UINT32                 "fmi3SetUInt32"                I | N | E | S | A;
    SET_INT64                  "fmi3SetInt64"                 I | N | E | S | A;
    SET_UINT64                 "fmi3SetUInt64"                I | N | E | S | A;
    SET_BOOLEAN                "fmi3SetBoolean"               I | N | E | S | A;
    SET_STRING                 "fmi3SetString"                I | N | E | S | A;
    SET_BINARY                 "fmi3SetBinary"                I | N | E | S | A;
    SET_CLOCK                  "fmi3SetClock"                 E;
    GET_INTERVAL_DECIMAL       "fmi3GetIntervalDecimal"       N | E;
    GET_INTERVAL_FRACTION      "fmi3GetIntervalFraction"      N | E;
    GET_SHIFT_DECIMAL          "fmi3GetShiftDecimal"          N;
    GET_SHIFT_FRACTION         "fmi3GetShiftFraction"         N;
    SET_INTERVAL_DECIMAL       "fmi3SetIntervalDecimal"       N | E;
    SET_INTERVAL_FRACTION      "fmi3SetIntervalFraction"      N | E;
    SET_SHIFT_DECIMAL          "fmi3SetShiftDecimal"          N | E;
    SET_SHIFT_FRACTION         "fmi3SetShiftFraction"         N | E;
    GET_NUMBER_OF_DEPENDENCIES "fmi3GetNumberOfVariableDependencies" I | N | E | S | A | T;
    GET_DEPENDENCIES           "fmi3GetVariableDependencies"  I | N | E | S | A | T;
    GET_DIRECTIONAL_DERIVATIVE "fmi3GetDirectionalDerivative" N | E | S | A | T;
    GET_ADJOINT_DERIVATIVE     "fmi3GetAdjointDerivative"     N | E | S | A | T;
    GET_OUTPUT_DERIVATIVES     "fmi3GetOutputDerivatives"     S | U | T;
    GET_FMU_STATE              "fmi3GetFMUState"              I | N | E | S | A | T;
    SET_FMU_STATE              "fmi3SetFMUState"              ANY;
    FREE_FMU_STATE             "fmi3FreeFMUState"             ANY;
    SERIALIZED_FMU_STATE_SIZE  "fmi3SerializedFMUStateSize"   ANY;
    SERIALIZE_FMU_STATE        "fmi3SerializeFMUState"        ANY;
    DESERIALIZE_FMU_STATE      "fmi3DeserializeFMUState"      ANY;
    // Of structural parameters, of which this FMU has none.
    ENTER_CONFIGURATION_MODE   "fmi3EnterConfigurationMode"   I | S | A;
    EXIT_CONFIGURATION_MODE    "fmi3ExitConfigurationMode"    ANY;
    // Of Model Exchange and Scheduled Execution, which this FMU does not offer.
    ENTER_CONTINUOUS_TIME_MODE "fmi3EnterContinuousTimeMode"  ANY;
    COMPLETED_INTEGRATOR_STEP  "fmi3CompletedIntegratorStep"  ANY;
    SET_TIME                   "fmi3SetTime"                  ANY;
    SET_CONTINUOUS_STATES      "fmi3SetContinuousStates"      ANY;
    GET_STATE_DERIVATIVES      "fmi3GetContinuousStateDerivatives" ANY;
    GET_EVENT_INDICATORS       "fmi3GetEventIndicators"       ANY;
    GET_CONTINUOUS_STATES      "fmi3GetContinuousStates"      ANY;
    GET_NOMINALS               "fmi3GetNominalsOfContinuousStates" ANY;
    GET_NUMBER_OF_INDICATORS   "fmi3GetNumberOfEventIndicators" ANY;
    GET_NUMBER_OF_STATES       "fmi3GetNumberOfContinuousStates" ANY;
    ACTIVATE_MODEL_PARTITION   "fmi3ActivateModelPartition"   ANY;
}
