//! Dry friction of slew, lift and tilt joint (Coulomb, Stribeck), for `dynamics` and `step`.
//!
//! Source: H. Olsson, K. J. Åström, C. Canudas de Wit, M. Gäfvert, P. Lischinsky, *Friction models
//! and friction compensation*, European Journal of Control 4(3), 1998: Coulomb friction with
//! Stribeck effect, its jump at rest rounded.

use model_rules::{ParamError, Range, check, check_each, require};
use serde::{Deserialize, Serialize};

/// Joints with dry friction.
const JOINTS: usize = 3;
/// Rate at which the friction has 76 % of its breakaway torque, rad/s. Below it the joint creeps.
const W_ROUND: f64 = 5e-4;
/// Stribeck rate, rad/s, above which the friction falls from breakaway to Coulomb torque.
const W_STRIBECK: f64 = 1e-2;

/// Dry friction of the slew, lift and tilt joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DryFriction {
    /// Coulomb friction, N·m; 0: none.
    pub torque: [f64; JOINTS],
    /// Breakaway torque over Coulomb friction.
    pub breakaway: f64,
    /// a: at positive rates friction is 1 + a times, at negative ones 1 − a times that.
    pub asymmetry: f64,
}

impl Default for DryFriction {
    fn default() -> Self {
        Self {
            torque: [0.0; JOINTS],
            breakaway: 1.0,
            asymmetry: 0.0,
        }
    }
}

impl DryFriction {
    pub(crate) fn check(&self) -> Result<(), ParamError> {
        check_each(Range::NotNegative, "joint_dry.torque", &self.torque)?;
        let (breakaway, rule) = (self.breakaway, "finite and ≥ 1");
        require("joint_dry.breakaway", breakaway, rule, breakaway >= 1.0)?;
        check(Range::Asymmetry, [("joint_dry.asymmetry", self.asymmetry)])
    }

    /// Torque against the rate `w`, rad/s, of joint `i`, and its derivative by the rate:
    /// ```text
    /// τ = τ_C (1 + (b − 1) e^(−(w/w_S)²)) r (1 + a r),   r = tanh(w/w_0)
    /// ```
    pub(crate) fn torque(&self, i: usize, w: f64) -> (f64, f64) {
        let coulomb = self.torque.get(i).copied().unwrap_or(0.0);
        if coulomb == 0.0 {
            return (0.0, 0.0);
        }
        let ratio = w / W_STRIBECK;
        let more = (self.breakaway - 1.0) * libm::exp(-ratio * ratio);
        let round = libm::tanh(w / W_ROUND);
        let uneven = 1.0 + self.asymmetry * round;
        let steeper = 1.0 + 2.0 * self.asymmetry * round;
        let by_w = (1.0 + more) * (1.0 - round * round) / W_ROUND * steeper
            - 2.0 * ratio / W_STRIBECK * more * round * uneven;
        (coulomb * (1.0 + more) * round * uneven, coulomb * by_w)
    }

    /// Bound of the slope of joint `i`, N·m·s/rad: that at zero rate, more by a at one side of it.
    pub(crate) fn steepest(&self, i: usize) -> f64 {
        let coulomb = self.torque.get(i).copied().unwrap_or(0.0);
        coulomb * self.breakaway * (1.0 + self.asymmetry.abs()) / W_ROUND
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRICTION: DryFriction = DryFriction {
        torque: [310.0, 170.0, 0.0],
        breakaway: 1.5,
        asymmetry: 0.0,
    };

    /// Friction by direction has the ratio (1 + a)/(1 − a); its slope is that of differences, with an error of
    /// (h/w_0)² at most.
    #[test]
    fn it_may_depend_on_the_direction() {
        let uneven = DryFriction {
            asymmetry: 0.2,
            ..FRICTION
        };
        let [out, back] = [0.5, -0.5].map(|w| uneven.torque(0, w).0);
        assert!((out / back + 1.5).abs() < 1e-12, "{out} {back}");
        let h = 1e-4 * W_ROUND;
        for w in [-2e-3, -1e-4, 0.0, 3e-4, 8e-3] {
            let [before, after] = [w - h, w + h].map(|w| uneven.torque(0, w).0);
            let slope = (after - before) / (2.0 * h);
            assert!((slope - uneven.torque(0, w).1).abs() < 1e-6 * uneven.steepest(0));
            assert!(slope <= uneven.steepest(0));
        }
    }

    /// Far above the Stribeck rate Coulomb friction is left; just above rest nearly the breakaway
    /// torque is reached (tanh 3 = 0.995, and the Stribeck curve has fallen by 2 %); it is odd.
    #[test]
    fn it_breaks_away_and_falls_to_coulomb_friction() {
        let at = |w| FRICTION.torque(0, w).0;
        assert!((at(0.2) - 310.0).abs() < 1e-9 && (at(-0.2) + 310.0).abs() < 1e-9);
        let highest = (1..200)
            .map(|k| at(1e-5 * f64::from(k)))
            .fold(0.0, f64::max);
        assert!(highest > 1.47 * 310.0 && highest < 1.5 * 310.0, "{highest}");
        assert_eq!(
            (at(0.0), FRICTION.torque(2, 0.3), FRICTION.torque(4, 0.3)),
            (0.0, (0.0, 0.0), (0.0, 0.0))
        );
    }

    /// The slope is the derivative (central difference, whose error is below 1e-4 of the largest).
    #[test]
    fn the_slope_is_the_derivative() {
        for w in [0.0, 3e-4, -2e-3, 8e-3, -0.03] {
            let h = 1e-7;
            let difference =
                (FRICTION.torque(1, w + h).0 - FRICTION.torque(1, w - h).0) / (2.0 * h);
            let (_, slope) = FRICTION.torque(1, w);
            assert!(
                (difference - slope).abs() < 1e-4 * FRICTION.steepest(1),
                "{w}: {difference}, {slope}"
            );
            assert!(slope.abs() <= FRICTION.steepest(1));
        }
    }
}
