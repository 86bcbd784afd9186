//! Inputs.

use serde::{Deserialize, Serialize};

/// What acts on the actuator at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Commanded direct-axis voltage, V.
    pub v_d: f64,
    /// Commanded quadrature-axis voltage, V.
    pub v_q: f64,
    /// Voltage of the DC link, V.
    pub v_dc: f64,
    /// Whether the inverter's gates are on, as they are by default. Read at the start of a step.
    pub enable: bool,
    /// Whether the holding brake is applied; a drive that has tripped applies it too. Read at the
    /// start of a step.
    pub brake: bool,
    /// Temperature around the actuator, K.
    pub T_ambient: f64,
    /// Rod position, m. In [`crate::Drive::Force`] read at the start only.
    pub x: f64,
    /// Rod velocity, m/s. In [`crate::Drive::Force`] read at the start only.
    pub x_dot: f64,
    /// External force on the rod against extension, N. [`crate::Drive::Force`] only.
    pub F_ext: f64,
    /// Force that the actuator delivers at the start, N. Read at the start only.
    pub F_hold: f64,
}

impl Default for Input {
    /// All zero; gates on, brake released.
    fn default() -> Self {
        Self {
            v_d: 0.0,
            v_q: 0.0,
            v_dc: 0.0,
            enable: true,
            brake: false,
            T_ambient: 0.0,
            x: 0.0,
            x_dot: 0.0,
            F_ext: 0.0,
            F_hold: 0.0,
        }
    }
}

impl Input {
    /// These inputs `s` seconds later: the rod moved on with its velocity, the rest held.
    #[must_use]
    pub fn moved(&self, s: f64) -> Self {
        Self {
            x: self.x + s * self.x_dot,
            ..*self
        }
    }
}
