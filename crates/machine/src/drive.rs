//! The two ways in which an actuator's rod meets its load.

use serde::{Deserialize, Serialize};

/// Who moves the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Drive {
    /// The rod follows the inputs `x` and `x_dot`; the force on it is the answer.
    Motion,
    /// The rod is a mass of its own against the input `F_ext`.
    Force,
}
