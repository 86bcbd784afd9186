//! Inputs of the DC link, as the FMU `DcLink` sets them: drive currents, ambient temperature.

use serde::{Deserialize, Serialize};

/// Number of drives on the link.
pub const LOADS: usize = 3;

/// What acts on the link; held over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Currents that the drives draw, A; negative when they feed back.
    pub i_load: [f64; LOADS],
    /// Temperature around the pack, K.
    pub T_ambient: f64,
}

impl Input {
    /// Current that all drives draw together, A.
    pub fn load(&self) -> f64 {
        self.i_load.iter().sum()
    }
}
