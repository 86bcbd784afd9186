//! Phases in the life of an instance.

use serde::{Deserialize, Serialize};

/// A discarded step leaves an instance in `Stepping`, as it was before the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Phase {
    /// Made or reset; nothing has been computed.
    Instantiated,
    /// Start values are exchanged.
    Initialization,
    /// At a communication point.
    Stepping,
    /// The simulation is over.
    Terminated,
    /// At a communication point, where values are exchanged until they agree; a step comes later.
    Exchange,
    /// Event Mode of Model Exchange.
    Event,
    /// Between events, where an importer integrates the continuous states.
    Continuous,
    /// Not initialized yet; sizes are set.
    Configuration,
}

impl Phase {
    /// Between initialization and the end.
    #[inline]
    pub(crate) fn is_running(self) -> bool {
        use Phase::{Continuous, Event, Exchange, Stepping};
        matches!(self, Stepping | Exchange | Event | Continuous)
    }
}
