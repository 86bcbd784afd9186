//! Inputs of an actuator and its drive mode, which both actuator models (`emla` and `rig`) share.

use crate::Dq;
use serde::{Deserialize, Serialize};

/// What determines the rod's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Drive {
    /// The rod follows the inputs `x` and `x_dot`; the actuator's force is the output.
    Motion,
    /// The rod is a free mass under the actuator's force and the input `F_ext`.
    Force,
}

/// Inputs of an actuator at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActuatorInput {
    /// Direct-axis voltage v_d, V (peak).
    pub v_d: f64,
    /// Quadrature-axis voltage v_q, V (peak).
    pub v_q: f64,
    /// Required quadrature-axis current, A (peak): drives with their own current loop read it
    /// instead of the voltages.
    pub i_q_required: f64,
    /// Voltage of the DC link, V, held over a step; None: [`crate::Emla::link_voltage`].
    pub v_dc: Option<f64>,
    /// Whether the inverter's gates are on (the default). Read at the start of a step.
    pub enable: bool,
    /// Whether the holding brake is applied; a drive that has tripped applies it too. Read at the
    /// start of a step.
    pub brake: bool,
    /// Ambient temperature, K; read if heat is modelled.
    pub T_ambient: f64,
    /// Rod position x, m, positive when extended. In [`Drive::Force`] read at the start only.
    pub x: f64,
    /// Rod velocity, m/s. In [`Drive::Force`] read at the start only.
    pub x_dot: f64,
    /// External force on the rod, N, positive against extension. [`Drive::Force`] only.
    pub F_ext: f64,
    /// Force that the actuator delivers at the start, N, positive when it pushes. Read at the start
    /// only.
    pub F_hold: f64,
}

impl Default for ActuatorInput {
    /// All zero; the machine's DC link, gates on, brake released.
    fn default() -> Self {
        Self {
            v_d: 0.0,
            v_q: 0.0,
            i_q_required: 0.0,
            v_dc: None,
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

impl ActuatorInput {
    /// Commanded voltage in dq coordinates, V.
    #[inline]
    pub fn voltage(&self) -> Dq {
        Dq {
            d: self.v_d,
            q: self.v_q,
        }
    }

    /// These inputs `s` seconds later, with the rod moved at constant velocity.
    ///
    /// Holding x while x_dot ≠ 0 would cost K_b·x_dot·h of force, some 20 kN at 1 ms.
    pub fn moved(&self, s: f64) -> Self {
        Self {
            x: self.x + s * self.x_dot,
            ..*self
        }
    }
}
