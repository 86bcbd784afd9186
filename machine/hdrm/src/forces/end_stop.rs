//! End stops of strokes and wrist, one-sided, stiff and dissipative, for `dynamics` and `step`.

use serde::{Deserialize, Serialize};

/// Natural frequency of the machine's effective mass on a stop, rad/s, chosen so that the static
/// penetration under full actuator force and weight is below 1 mm (113 kN on 14 t: 0.8 mm).
const STOP_FREQUENCY: f64 = 100.0;

/// Hunt–Crossley dissipation of an actuator's stop, s/m. A body with the speed v penetrates by at
/// most `√(2v/(ω²c))`, 2 mm at 4 m/s, and rebounds with less than 1/c = 5 mm/s.
pub(crate) const STROKE_DISSIPATION: f64 = 200.0;

/// The same for a wrist joint, s/rad: at most 1.3° at 10 rad/s.
pub(crate) const JOINT_DISSIPATION: f64 = 50.0;

/// Stops at both ends of the range of one stroke (m, N) or joint angle (rad, N·m).
///
/// The force is `k·d·max(0, 1 + c·d_dot)` for the penetration d and its rate d_dot (Hunt–Crossley),
/// zero for d ≤ 0: continuous, never pulling, and passive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndStop {
    /// Ends of the free range.
    pub range: [f64; 2],
    /// Stiffness k, N/m or N·m/rad.
    pub stiffness: f64,
    /// Dissipation c, s/m or s/rad.
    pub dissipation: f64,
}

/// Penetration into one end.
#[derive(Clone, Copy, Debug)]
struct Contact {
    /// Direction of the force: +1 at the lower end.
    sign: f64,
    /// Penetration; negative: distance.
    d: f64,
    d_dot: f64,
}

impl EndStop {
    /// A stop for an effective mass, kg or kg·m².
    pub(crate) fn new(range: [f64; 2], mass: f64, dissipation: f64) -> Self {
        Self {
            range,
            stiffness: mass * STOP_FREQUENCY * STOP_FREQUENCY,
            dissipation,
        }
    }

    /// The end the coordinate is nearest to.
    fn contact(&self, y: f64, y_dot: f64) -> Contact {
        let [min, max] = self.range;
        if y < 0.5 * (min + max) {
            Contact {
                sign: 1.0,
                d: min - y,
                d_dot: -y_dot,
            }
        } else {
            Contact {
                sign: -1.0,
                d: y - max,
                d_dot: y_dot,
            }
        }
    }

    /// Distance from the nearer end, negative inside the stop.
    pub(crate) fn distance(&self, y: f64) -> f64 {
        -self.contact(y, 0.0).d
    }

    /// Force on the coordinate, positive towards larger `y`.
    pub fn force(&self, y: f64, y_dot: f64) -> f64 {
        let Contact { sign, d, d_dot } = self.contact(y, y_dot);
        sign * self.stiffness * d.max(0.0) * (1.0 + self.dissipation * d_dot).max(0.0)
    }

    /// Time derivative of [`EndStop::force`]; `k·(d_dot·(1 + c·d_dot) + d·c·d_ddot)` in contact.
    pub fn force_rate(&self, y: f64, y_dot: f64, y_ddot: f64) -> f64 {
        let Contact { sign, d, d_dot } = self.contact(y, y_dot);
        let pressure = 1.0 + self.dissipation * d_dot;
        if d <= 0.0 || pressure <= 0.0 {
            return 0.0;
        }
        let d_ddot = -sign * y_ddot;
        sign * self.stiffness * (d_dot * pressure + d * self.dissipation * d_ddot)
    }

    /// Fastest rate, 1/s, of the contact within the time `dt` on a coordinate with the mobility μ
    /// (acceleration per force): `√(kμ) + kμ·c·d` at the largest expected penetration; 0: out of
    /// reach.
    pub(crate) fn rate_ahead(&self, y: f64, y_dot: f64, mobility: f64, dt: f64) -> f64 {
        let Contact { d, d_dot, .. } = self.contact(y, y_dot);
        let ahead = d + d_dot.max(0.0) * dt;
        if ahead <= 0.0 {
            return 0.0;
        }
        let stiffness = self.stiffness * mobility;
        stiffness.sqrt() + stiffness * self.dissipation * ahead
    }

    /// Whether the coordinate can touch an end within `dt`.
    pub(crate) fn is_near(&self, y: f64, y_dot: f64, dt: f64) -> bool {
        let Contact { d, d_dot, .. } = self.contact(y, y_dot);
        d + d_dot.max(0.0) * dt > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: ω = √(kμ) = 6 1/s, and kμ·c·d = 36 · 0.5 · d at the deepest penetration ahead.
    #[test]
    fn the_fastest_rate_is_that_of_the_deepest_contact_ahead() {
        let stop = EndStop {
            range: [-1.0, 2.0],
            stiffness: 9.0,
            dissipation: 0.5,
        };
        let rate = |y, y_dot| stop.rate_ahead(y, y_dot, 4.0, 0.25);
        assert_eq!(rate(2.5, 0.0), 6.0 + 18.0 * 0.5);
        assert_eq!(rate(2.5, 2.0), 6.0 + 18.0 * 1.0); // on its way in
        assert_eq!(rate(2.5, -2.0), 6.0 + 18.0 * 0.5); // on its way out
        assert_eq!(rate(-1.25, -1.0), 6.0 + 18.0 * 0.5);
        assert_eq!(rate(1.75, 2.0), 6.0 + 18.0 * 0.25); // arrives
        assert_eq!(rate(1.75, 1.0), 0.0);
    }
}
