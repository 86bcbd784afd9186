//! State: joint angles and rates, and energies that follow from neither.

use crate::DOF;
use crate::forces::wrist_drive::WristState;
use serde::{Deserialize, Serialize};

/// Joint angles and rates, and the energies that the machine's own do not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Joint angles, rad.
    pub zeta: [f64; DOF],
    /// Joint rates, rad/s.
    pub zeta_dot: [f64; DOF],
    /// Energy that the contact has turned into heat, J.
    pub contact_loss: f64,
    /// Energy that changes of the load have brought, J.
    pub load_energy: f64,
    /// The wrist's drives as built; at rest of ideal ones.
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
