//! The phases of an instance, for `core`, `fmi3` and the call order: FMI's states outside a step.

use serde::{Deserialize, Serialize};

/// The phase of an instance. Its number is that of its bit in the call order. A discarded step
/// leaves the instance in `Stepping`, as it was before the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Phase {
    /// Instantiated or reset; nothing has been computed.
    Instantiated = 0,
    /// Initialization Mode.
    Initialization = 1,
    /// At a communication point.
    Stepping = 2,
    /// The simulation is over.
    Terminated = 3,
    /// Event Mode of Co-Simulation: at a communication point, values are exchanged.
    Exchange = 5,
    /// Event Mode of Model Exchange.
    Event = 8,
    /// Continuous-Time Mode: the importer integrates the continuous states.
    Continuous = 9,
    /// Configuration Mode: before initialization, sizes are set.
    Configuration = 12,
    /// Clock Activation Mode of Scheduled Execution.
    Scheduled = 13,
}

impl Phase {
    /// Between initialization and the end.
    #[inline]
    pub(crate) fn is_running(self) -> bool {
        use Phase::{Continuous, Event, Exchange, Scheduled, Stepping};
        matches!(self, Stepping | Exchange | Event | Continuous | Scheduled)
    }
}
