//! Kinematics of the tilt for `Tree`: four-bar linkage A–B–C–D and the actuator from E to D.

use crate::geometry::planar::{Derivatives, Polar, perp, turned, turning, unit};
use machine_file::Geometry;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// Constants of the tilt mechanism. Points are relative to the tilt joint B; A and E are fixed to
/// the lift boom and given in boom axes, C is fixed to the tilt boom and given in its axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tilt {
    /// Rocker pivot, m.
    pub A: Vector2<f64>,
    /// Foot of the actuator, m.
    pub E: Vector2<f64>,
    /// Coupler pivot, m.
    pub C: Vector2<f64>,
    /// Rocker length |AD|, m.
    pub d4: f64,
    /// Coupler length |CD|, m.
    pub d5: f64,
    /// Actuator length at stroke zero, m.
    pub x0: f64,
    /// Length of the rod body behind its pin, m.
    pub lc: f64,
    /// Branch of the loop: +1 if D is clockwise of the line A → C, −1 if counter-clockwise; the
    /// side away from B over the working range, constant so that the branch never jumps.
    pub side: f64,
}

/// The four-bar and its actuator at one `zeta_3`, all in boom axes relative to B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourBar {
    /// Coupler pivot C, m.
    pub C: Vector2<f64>,
    /// Pin D of rocker, coupler and rod, m.
    pub D: Vector2<f64>,
    /// Unit vector A → D of the rocker.
    pub e_rocker: Vector2<f64>,
    /// Derivatives of the rocker's angle by `zeta_3`.
    pub rocker_d: Derivatives<f64>,
    /// Unit vector C → D of the coupler.
    pub e_coupler: Vector2<f64>,
    /// Derivatives of the coupler's angle (in boom axes) by `zeta_3`.
    pub coupler_d: Derivatives<f64>,
    /// The actuator vector E → D.
    pub actuator: Polar,
}

impl Tilt {
    pub(crate) fn new(g: &Geometry, zeta_3_mid: f64) -> Self {
        let (A, C) = (Vector2::from(g.A_in_boom), Vector2::from(g.C_in_tilt));
        Self {
            A,
            E: g.E_in_boom.into(),
            C,
            d4: g.d4,
            d5: g.d5,
            x0: g.x0_3,
            lc: g.lc_3,
            side: A.perp(&turned(C, unit(zeta_3_mid))).signum(),
        }
    }

    /// Whether rocker and coupler can meet at this angle.
    pub(crate) fn closes(&self, zeta_3: f64) -> bool {
        let d3 = (turned(self.C, unit(zeta_3)) - self.A).norm();
        d3 < self.d4 + self.d5 && d3 > (self.d4 - self.d5).abs()
    }

    /// Solves the loop from the unit vector of the tilt boom in boom axes (angle `zeta_3`).
    ///
    /// D is the intersection of the circles about A and C. With a, b the angles of rocker and
    /// coupler the loop is `d4 e(a) − d5 e(b) = C − A`; its derivatives are linear in those of a
    /// and b with the same matrix each time.
    pub fn four_bar(&self, e_tilt: Vector2<f64>) -> FourBar {
        let &Self { A, E, d4, d5, .. } = self;
        let C = turned(self.C, e_tilt);
        let D = self.pin(C);
        let (e_a, e_b) = ((D - A) / d4, (D - C) / d5);
        let (n_a, n_b) = (perp(e_a), perp(e_b));

        // d4 n_a x − d5 n_b y = r  ⇒  x = r·e_b / (d4 s), y = r·e_a / (d5 s), s = sin(b − a)
        let inv_s = e_a.perp(&e_b).recip();
        let solve = |r: Vector2<f64>| (r.dot(&e_b) * inv_s / d4, r.dot(&e_a) * inv_s / d5);
        let [C1, C2, C3] = turning(C);
        let (a1, b1) = solve(C1);
        let (a2, b2) = solve(C2 + e_a * (d4 * a1 * a1) - e_b * (d5 * b1 * b1));
        let third = |e: Vector2<f64>, n: Vector2<f64>, q1: f64, q2: f64| {
            n * (q1 * q1 * q1) + e * (3.0 * q1 * q2)
        };
        let (a3, b3) = solve(C3 + third(e_a, n_a, a1, a2) * d4 - third(e_b, n_b, b1, b2) * d5);

        let D1 = n_a * (d4 * a1);
        let D2 = (n_a * a2 - e_a * (a1 * a1)) * d4;
        let D3 = (n_a * a3 - third(e_a, n_a, a1, a2)) * d4;
        FourBar {
            C,
            D,
            e_rocker: e_a,
            rocker_d: [a1, a2, a3],
            e_coupler: e_b,
            coupler_d: [b1, b2, b3],
            actuator: Polar::new(D - E, [D1, D2, D3]),
        }
    }

    /// D from C: along A → C by `(d3² + d4² − d5²)/(2 d3)`, then across on the side away from B.
    fn pin(&self, C: Vector2<f64>) -> Vector2<f64> {
        let &Self {
            A, d4, d5, side, ..
        } = self;
        let AC = C - A;
        let d3_squared = AC.norm_squared();
        let along = 0.5 * (1.0 + (d4 * d4 - d5 * d5) / d3_squared);
        let across = (d4 * d4 / d3_squared - along * along).sqrt();
        A + AC * along - perp(AC) * (side * across)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::Machine;

    /// Oracle: the pin of rocker and coupler, which is a real point exactly where the two circles
    /// meet.
    #[test]
    fn the_loop_closes_where_it_has_a_pin() {
        let mut tilt = Tilt::new(&Machine::reference().geometry, -1.5);
        // Rocker and coupler so short that they reach each other at some angles only.
        let scale = tilt.A.norm() / (tilt.d4 + tilt.d5);
        (tilt.d4, tilt.d5) = (scale * tilt.d4, scale * tilt.d5);
        let mut closed = 0;
        for k in 0..720 {
            let zeta = f64::from(k) * std::f64::consts::TAU / 720.0;
            let has_pin = !tilt.four_bar(unit(zeta)).D.x.is_nan();
            assert_eq!(tilt.closes(zeta), has_pin, "{zeta}");
            closed += u32::from(has_pin);
        }
        assert!((100..620).contains(&closed), "{closed} of 720");
    }
}
