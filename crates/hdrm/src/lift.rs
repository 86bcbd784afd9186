//! The lift mechanism: a triangle of boom, base and actuator (the paper's three-bar).

use crate::planar::{Polar, angle_between, turning, unit};
use machine::Geometry;
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

/// The paper's lift variables at one `zeta_2` (`[paper] Eq. (Eq:3_Bar_2)`, `(Eq:3_Bar_3)`), rad
/// and m. Angles by atan2, which equals the paper's arccos where that is defined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftAngles {
    /// `q_2 = zeta_2 − π/2 − beta1 − beta2`.
    pub q: f64,
    /// `q_1_2`, turn of the actuator against the line foot → O.
    pub q1: f64,
    /// `q_2_2 = q_2 − q_1_2`.
    pub q2: f64,
    /// `dq_1_2/dzeta_2`.
    pub q1_prime: f64,
    /// Actuator length `c_2 = x_2 + x0_2`, m.
    pub c: f64,
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
    #[must_use]
    pub fn actuator(&self, e_A2: Vector2<f64>) -> Polar {
        let pin = e_A2 * self.L1;
        Polar::new(pin - self.foot, turning(pin))
    }

    /// The paper's variables at `zeta_2`.
    #[must_use]
    pub fn angles(&self, zeta_2: f64) -> LiftAngles {
        let e_A2 = unit(zeta_2 - self.beta2);
        let actuator = self.actuator(e_A2);
        // A2's x axis is at q_2 + π from the foot's direction; atan2 keeps q_2 in (−π, π].
        let q = angle_between(self.foot, -e_A2);
        let q1 = angle_between(-self.foot, actuator.e);
        LiftAngles {
            q,
            q1,
            q2: q - q1,
            q1_prime: actuator.angle_d[0],
            c: actuator.length,
        }
    }
}
