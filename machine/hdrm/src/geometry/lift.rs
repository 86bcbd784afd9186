//! Kinematics of the lift for `Tree`: triangle of boom, base and actuator (the paper's three-bar).

use crate::geometry::planar::{Polar, turning};
use machine_file::Geometry;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// Constants of the lift triangle. Points are relative to the lift joint O, in T1's axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lift {
    /// |O → rod pin|, m.
    pub L1: f64,
    /// |O → cylinder foot|, m.
    pub L2: f64,
    /// Cylinder foot from O, `L2·(sin beta1, −cos beta1)`, m.
    pub foot: Vector2<f64>,
    /// Elevation of the boom axis over the line O → rod pin, rad.
    pub beta2: f64,
    /// Actuator length at stroke zero, m.
    pub x0: f64,
    /// Length of the rod body behind its pin, m.
    pub lc: f64,
}

impl Lift {
    pub(crate) fn new(g: &Geometry) -> Self {
        let (s, c) = libm::sincos(g.beta1);
        Self {
            L1: g.L1_2,
            L2: g.L2_2,
            foot: Vector2::new(s, -c) * g.L2_2,
            beta2: g.beta2,
            x0: g.x0_2,
            lc: g.lc_2,
        }
    }

    /// The actuator vector foot → rod pin in T1's axes, from the unit vector of A2's x axis
    /// (O → rod pin, elevation `zeta_2 − beta2`).
    pub fn actuator(&self, e_A2: Vector2<f64>) -> Polar {
        let pin = e_A2 * self.L1;
        Polar::new(pin - self.foot, turning(pin))
    }
}
