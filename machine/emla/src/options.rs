//! Options of the electrical side: undervoltage trip, heat, temperature.

use serde::{Deserialize, Serialize};

/// What of the electrical side is modelled beyond the paper; by default nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Electric {
    /// Voltage of the DC link below which an enabled drive trips, V; 0: never.
    pub undervoltage: f64,
    /// Whether the losses warm winding and housing; else these stay at their start.
    pub heat: bool,
    /// Whether resistance and magnets follow their temperature.
    pub temperature: bool,
}
