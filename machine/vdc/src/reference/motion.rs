//! The joints' reference under commanded rates.

use crate::nominal::orientation;
use crate::reference::desired::DesiredMotion;
use hdrm::{DOF, Tip, Tree};
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

/// Where commands are held back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CommandHolds {
    /// By the end of a joint's range.
    pub joint: [bool; DOF],
    /// Before the arm is stretched.
    pub elbow: bool,
    /// The wrist is near its singularity, where the tip follows in part.
    pub wrist: bool,
    /// By the rate of a joint, counted from 0, of which the tip's command asks so much, rad/s.
    pub rate: Option<(usize, f64)>,
}

/// Angles, rates and accelerations of the joints' reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Motion {
    /// ζ_d, rad, and its derivatives.
    pub(crate) zeta: Vector6<f64>,
    pub(crate) zeta_dot: Vector6<f64>,
    pub(crate) zeta_ddot: Vector6<f64>,
    pub(crate) held: CommandHolds,
}

impl Motion {
    /// At rest in the pose `zeta`, rad.
    pub(crate) fn rest(zeta: &[f64; DOF]) -> Self {
        Self {
            zeta: Vector6::from(*zeta),
            ..Self::default()
        }
    }

    /// The motion `h` s later, where it comes to rest in `left` s, at the latest at that.
    pub(crate) fn advance_to_rest(&mut self, left: f64, h: f64) {
        // Also where rounding leaves a remainder.
        let is_last = left <= h * (1.0 + 1e-9);
        let h = h.min(left);
        self.zeta += (self.zeta_dot + self.zeta_ddot * (0.5 * h)) * h;
        self.zeta_dot += self.zeta_ddot * h;
        if is_last {
            (self.zeta_dot, self.zeta_ddot) = (Vector6::zeros(), Vector6::zeros());
        }
    }

    /// The tip where the joints' reference has it.
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
