//! Options beyond the paper (undervoltage trip, heat) of the FMU and of the study `surrogate`.

use serde::{Deserialize, Serialize};

/// Options of the electrical side; by default all off, as in the paper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Electric {
    /// Voltage of the DC link below which an enabled drive trips, V; 0: never.
    pub undervoltage: f64,
    /// Whether the losses heat winding and housing; otherwise their temperatures are constant.
    pub heat: bool,
    /// Whether resistance and flux depend on the temperatures.
    pub temperature: bool,
}
