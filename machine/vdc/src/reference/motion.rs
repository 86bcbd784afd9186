//! Reference motion of the joints, advanced by `rates` or, in a stop, by the supervisor.

use crate::nominal::orientation;
use crate::reference::desired::DesiredMotion;
use hdrm::{DOF, Tip, Tree};
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

/// Why commanded rates are limited at present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CommandHolds {
    /// A joint is at the end of its range.
    pub joint: [bool; DOF],
    /// The arm is nearly stretched.
    pub elbow: bool,
    /// The wrist is near its singularity, where the tip follows only partly.
    pub wrist: bool,
    /// A joint (counted from 0) would exceed its rate; the rate for the whole command, rad/s.
    pub rate: Option<(usize, f64)>,
    /// A rod (counted from 0) would not hold the machine at rest.
    pub rod: Option<usize>,
}

/// Angles, rates and accelerations of the joints' reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Motion {
    /// ζ_d, rad, and its derivatives.
    pub(crate) zeta: Vector6<f64>,
    pub(crate) zeta_dot: Vector6<f64>,
    pub(crate) zeta_ddot: Vector6<f64>,
    pub(crate) held: CommandHolds,
    /// Direction in which a joint does not follow its reference, ±1; 0: it follows.
    pub(crate) blocked: [f64; DOF],
}

impl Motion {
    /// Whether a joint does not follow, so that nothing can be learnt from its error.
    pub(crate) fn is_blocked(&self) -> bool {
        self.are_blocked().contains(&true)
    }

    /// Whether a joint of the boom, and one of the wrist, does not follow.
    pub(crate) fn are_blocked(&self) -> [bool; 2] {
        let (boom, wrist) = self.blocked.split_at(3);
        [boom, wrist].map(|joints| joints.iter().any(|direction| *direction != 0.0))
    }

    pub(crate) fn rest(zeta: &[f64; DOF]) -> Self {
        Self {
            zeta: Vector6::from(*zeta),
            ..Self::default()
        }
    }

    /// Advances by `h` s, but never past the stop in `left` s.
    pub(crate) fn advance_to_rest(&mut self, left: f64, h: f64) {
        // With a tolerance for rounding.
        let is_last = left <= h * (1.0 + 1e-9);
        let h = h.min(left);
        self.zeta += (self.zeta_dot + self.zeta_ddot * (0.5 * h)) * h;
        self.zeta_dot += self.zeta_ddot * h;
        if is_last {
            (self.zeta_dot, self.zeta_ddot) = (Vector6::zeros(), Vector6::zeros());
        }
    }

    /// Motion of the tip for this motion of the joints.
    pub(crate) fn tip(&self, tree: &Tree) -> DesiredMotion {
        let Self {
            zeta,
            zeta_dot,
            zeta_ddot,
            ..
        } = self;
        let [zeta, rates] = [*zeta, *zeta_dot].map(<[f64; DOF]>::from);
        let tip = Tip::new(tree, &tree.configuration(&zeta));
        let J = tip.jacobian();
        let V = J * zeta_dot;
        let A = J * zeta_ddot + tip.jacobian_dot(&rates) * zeta_dot;
        DesiredMotion {
            position: tip.position,
            velocity: V.fixed_rows::<3>(0).into(),
            acceleration: A.fixed_rows::<3>(0).into(),
            orientation: orientation(&zeta),
            angular_velocity: V.fixed_rows::<3>(3).into(),
        }
    }
}
