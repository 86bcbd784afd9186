//! Holding brakes of the wrist, for `step` and `continuous`: dry friction that takes time to close.
//!
//! On drives as built a brake acts on the motor, behind the gear. On ideal drives, which have no
//! motor, it holds the joint by an elastic anchor that yields at the brake's torque. Source: P.
//! Dupont, V. Hayward, B. Armstrong, F. Altpeter, *Single state elastoplastic friction models*, IEEE
//! Transactions on Automatic Control 47(5), 2002; below [`ELASTIC`] of its torque nothing creeps.

use crate::forces::wrist_drive::{DAMPING_RATIO, WristDrive, WristState};
use model_rules::{ParamError, Range, check, check_each};
use serde::{Deserialize, Serialize};

/// Share of the brake's torque up to which the anchor is elastic.
const ELASTIC: f64 = 0.8;
/// Torque of a brake over the largest torque of its drive, as usual for holding brakes.
const TORQUE: f64 = 1.5;

/// Parameters of the wrist's brakes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WristBrake {
    /// Time from the command until the torque acts, s; a brake opens at once.
    pub closing_time: f64,
    /// Torque up to which they hold and with which they slip, N·m.
    pub torque: [f64; 3],
}

impl WristBrake {
    /// Brakes for drives with these largest torques, N·m, that act at once.
    pub(crate) fn for_drives(largest: [f64; 3]) -> Self {
        Self {
            closing_time: 0.0,
            torque: largest.map(|tau| TORQUE * tau),
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParamError> {
        check(
            Range::NotNegative,
            [("brake.closing_time", self.closing_time)],
        )?;
        check_each(Range::Positive, "brake.torque", &self.torque)
    }

    /// How long the torque of a commanded brake is still awaited, s; 0 while it acts.
    pub(crate) fn awaited(&self, now: &WristState) -> f64 {
        match now.holds {
            true => 0.0,
            false => (self.closing_time - now.braked).max(0.0),
        }
    }
}

/// The elastic anchor of an ideal drive's brake.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Anchor {
    /// N·m.
    torque: f64,
    /// N·m/rad.
    stiffness: f64,
    /// N·m·s/rad.
    damping: f64,
}

impl Anchor {
    /// The anchors of the three joints: as stiff and damped as the gears of `drive`.
    pub(crate) fn all(brake: &WristBrake, drive: &WristDrive) -> [Self; 3] {
        std::array::from_fn(|i| {
            let (K, J) = (drive.stiffness[i], drive.inertia[i]);
            Self {
                torque: brake.torque[i],
                stiffness: K,
                damping: 2.0 * DAMPING_RATIO * (K * J).sqrt(),
            }
        })
    }

    /// Share of the rate `w`, rad/s, with which the anchor follows a joint that is the angle `s`,
    /// rad, away from it.
    fn yielding(&self, s: f64, w: f64) -> f64 {
        let load = self.stiffness * s / self.torque;
        if load.abs() <= ELASTIC || load * w <= 0.0 {
            return 0.0;
        }
        let x = ((load.abs() - ELASTIC) / (1.0 - ELASTIC)).min(1.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// Torque that spring and damper give a joint at the angle and rate `joint`, rad and rad/s, N·m.
    fn elastic_torque(&self, now: &WristState, [zeta, w]: [f64; 2]) -> f64 {
        let s = zeta - now.angle;
        -(self.stiffness * s + self.damping * w * (1.0 - self.yielding(s, w)))
    }

    /// Torque on a joint at the angle and rate `joint`, rad and rad/s, N·m: never above the brake's.
    pub(crate) fn torque(&self, now: &WristState, joint: [f64; 2]) -> f64 {
        (self.elastic_torque(now, joint)).clamp(-self.torque, self.torque)
    }

    /// Time derivative of that torque with the joint's acceleration `a`, rad/s², N·m/s, while the
    /// anchor yields as it does.
    pub(crate) fn torque_rate(&self, now: &WristState, [zeta, w]: [f64; 2], a: f64) -> f64 {
        if self.elastic_torque(now, [zeta, w]).abs() >= self.torque {
            return 0.0;
        }
        let bends = 1.0 - self.yielding(zeta - now.angle, w);
        -(self.stiffness * w + self.damping * a) * bends
    }

    /// Rate of the anchor's angle, rad/s, for Model Exchange.
    pub(crate) fn rate(&self, now: &WristState, [zeta, w]: [f64; 2]) -> f64 {
        w * self.yielding(zeta - now.angle, w)
    }

    /// The anchor's angle, rad, after a substep that ends with `joint`.
    pub(crate) fn slid(&self, now: &WristState, joint: [f64; 2], dt: f64) -> f64 {
        let angle = now.angle + dt * self.rate(now, joint);
        let most = self.torque / self.stiffness;
        joint[0] - (joint[0] - angle).clamp(-most, most)
    }

    /// The angle, rad, from which the brake holds a joint at `zeta`, rad, with the torque `tau`, N·m.
    pub(crate) fn holding(&self, zeta: f64, tau: f64) -> f64 {
        zeta + tau.clamp(-self.torque, self.torque) / self.stiffness
    }

    /// Upper bound of the rates, 1/s, of the anchor with a joint of this mobility, 1/(kg·m²).
    pub(crate) fn fastest(&self, mobility: f64) -> f64 {
        (self.stiffness * mobility).sqrt() + self.damping * mobility
    }
}
