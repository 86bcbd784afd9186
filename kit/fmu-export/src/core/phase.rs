//! Phases in the life of an instance.

use serde::{Deserialize, Serialize};

/// The numbers are those of the bits in the border's call order.
///
/// A discarded step leaves an instance in `Stepping`, as it was before the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Phase {
    /// Made or reset; nothing has been computed.
    Instantiated = 0,
    /// Start values are exchanged.
    Initialization = 1,
    /// At a communication point.
    Stepping = 2,
    /// The simulation is over.
    Terminated = 3,
    /// At a communication point, where values are exchanged until they agree; a step comes later.
    Exchange = 5,
    /// Event Mode of Model Exchange.
    Event = 8,
    /// Between events, where an importer integrates the continuous states.
    Continuous = 9,
    /// Not initialized yet; sizes are set.
    Configuration = 12,
}

impl Phase {
    /// Between initialization and the end.
    #[inline]
    pub(crate) fn is_running(self) -> bool {
        use Phase::{Continuous, Event, Exchange, Stepping};
        matches!(self, Stepping | Exchange | Event | Continuous)
    }
}
