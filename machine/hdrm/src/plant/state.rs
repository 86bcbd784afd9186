//! State of the manipulator, which the FMU saves: angles, rates, energies, and the wrist's drives.

use crate::DOF;
use crate::forces::wrist_drive::WristState;
use serde::{Deserialize, Serialize};

/// State of the manipulator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Joint angles, rad.
    pub zeta: [f64; DOF],
    /// Joint rates, rad/s.
    pub zeta_dot: [f64; DOF],
    /// Energy dissipated by the contact, J.
    pub contact_loss: f64,
    /// Energy added by changes of the load, J.
    pub load_energy: f64,
    /// The wrist's drives as built; unused for ideal ones.
    pub wrist: [WristState; 3],
}

impl State {
    /// The machine at rest in the pose `zeta`, rad.
    pub(crate) fn at_rest(zeta: [f64; DOF]) -> Self {
        Self {
            zeta,
            ..Self::default()
        }
    }
}
