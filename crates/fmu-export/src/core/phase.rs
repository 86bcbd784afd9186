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
}
