//! Sets of states for the call order of FMI 3.0 (FMI 3.0.2, sections 2.3 and 4.2.1), and the names
//! of the states in messages. Each function in `entry` names the states in which it is allowed.

pub(crate) use crate::c_api::call_order::CLOCK_ACTIVATION;
use crate::c_api::call_order::*;

/// Step Mode, where values were set since the last step: nothing can be read before the next one
/// (section 4.2.1). What must be exchanged at a communication point goes through Event Mode.
pub(crate) const STEP_MODE_AFTER_SET: u16 = 128;

/// Event Mode of either interface.
pub(crate) const EVENT_MODE: u16 = CS_EVENT_MODE | ME_EVENT_MODE;
/// From Initialization Mode until the end, except within a step.
pub(crate) const INITIALIZED: u16 = INITIALIZATION_MODE
    | EVENT_MODE
    | STEP_MODE
    | STEP_MODE_AFTER_SET
    | CONTINUOUS_TIME_MODE
    | CLOCK_ACTIVATION
    | TERMINATED;
/// Every state except the callback within a step.
pub(crate) const ANY: u16 = INSTANTIATED | CONFIGURATION_MODE | INITIALIZED | LOST;
/// The states in which variables can be read.
pub(crate) const GET: u16 = INSTANTIATED | INTERMEDIATE_UPDATE | INITIALIZED & !STEP_MODE_AFTER_SET;
/// The states in which variables can be set; continuous inputs in Continuous-Time Mode too.
pub(crate) const SET: u16 = INSTANTIATED
    | INITIALIZATION_MODE
    | EVENT_MODE
    | STEP_MODE
    | STEP_MODE_AFTER_SET
    | CLOCK_ACTIVATION;

/// The states' names in messages.
pub(crate) const STATES: [(u16, &str); 12] = [
    (INSTANTIATED, "Instantiated"),
    (CONFIGURATION_MODE, "Configuration Mode"),
    (INITIALIZATION_MODE, "Initialization Mode"),
    (CS_EVENT_MODE, "Event Mode"),
    (STEP_MODE, "Step Mode"),
    (STEP_MODE_AFTER_SET, "Step Mode after a set"),
    (INTERMEDIATE_UPDATE, "Intermediate Update Mode"),
    (ME_EVENT_MODE, "Event Mode"),
    (CONTINUOUS_TIME_MODE, "Continuous-Time Mode"),
    (CLOCK_ACTIVATION, "Clock Activation Mode"),
    (TERMINATED, "Terminated"),
    (LOST, "lost by a panic"),
];
