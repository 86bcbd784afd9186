//! Call order of the FMI functions of both versions: the states of an instance, as bits, and the
//! rule of a function (its name and the states in which it may be called), which
//! [`enter`](super::fmi_instance::enter) checks in each call.

use crate::Model;
use crate::core::instance::Instance;
use crate::core::phase::Phase;

/// Instantiated or reset; nothing has been computed.
pub(crate) const INSTANTIATED: u16 = bit(Phase::Instantiated);
/// Initialization Mode.
pub(crate) const INITIALIZATION_MODE: u16 = bit(Phase::Initialization);
/// At a communication point, ready for a step.
pub(crate) const STEP_MODE: u16 = bit(Phase::Stepping);
/// Terminated.
pub(crate) const TERMINATED: u16 = bit(Phase::Terminated);
/// After a panic, the state Error of FMI 2.0: a reset or a restored state leads out of it.
pub(crate) const LOST: u16 = 16;
/// Event Mode of Co-Simulation in FMI 3.0: at a communication point, values are exchanged.
pub(crate) const CS_EVENT_MODE: u16 = bit(Phase::Exchange);
/// Intermediate Update Mode of FMI 3.0: within a step, in the importer's callback.
pub(crate) const INTERMEDIATE_UPDATE: u16 = 64;

/// Event Mode of Model Exchange.
pub(crate) const ME_EVENT_MODE: u16 = bit(Phase::Event);
/// Continuous-Time Mode of Model Exchange.
pub(crate) const CONTINUOUS_TIME_MODE: u16 = bit(Phase::Continuous);
/// Configuration Mode of FMI 3.0: before initialization, structural parameters are set.
pub(crate) const CONFIGURATION_MODE: u16 = bit(Phase::Configuration);
/// The states that only Model Exchange has.
pub(crate) const ME_STATES: u16 = ME_EVENT_MODE | CONTINUOUS_TIME_MODE;
/// The states that both interfaces have.
pub(crate) const COMMON_STATES: u16 =
    INSTANTIATED | CONFIGURATION_MODE | INITIALIZATION_MODE | TERMINATED | LOST;

/// Not a state: the function is for instances of Co-Simulation only.
pub(crate) const CS: u16 = 1024;
/// Not a state: the function is for instances of Model Exchange only.
pub(crate) const ME: u16 = 2048;
/// Clock Activation Mode of Scheduled Execution.
pub(crate) const CLOCK_ACTIVATION: u16 = bit(Phase::Scheduled);
/// Not a state: the function is for instances of Scheduled Execution only.
pub(crate) const SE: u16 = 16384;

/// The bit of a phase, by its number: faster than a table.
const fn bit(phase: Phase) -> u16 {
    1 << phase as u16
}

/// The bit of the state of an instance outside a step.
#[inline]
pub(crate) fn state<M: Model>(instance: &Instance<M>) -> u16 {
    match instance.lost {
        true => LOST,
        false => bit(instance.state.phase),
    }
}

/// The call order rule of a function: its name, and the states and interfaces it is allowed in.
#[derive(Clone, Copy)]
pub(crate) struct Call {
    pub(crate) name: &'static str,
    pub(crate) allowed: u16,
}

impl Call {
    /// For all interfaces, unless `allowed` has [`CS`], [`ME`] or [`SE`].
    #[inline(always)]
    pub(crate) const fn new(name: &'static str, allowed: u16) -> Self {
        let interfaces = match allowed & (CS | ME | SE) {
            0 => CS | ME | SE,
            _ => 0,
        };
        Self {
            name,
            allowed: allowed | interfaces,
        }
    }
}
