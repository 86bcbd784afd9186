//! Limits of an operator's commanded rates of joints or tip, which the FMU sets and `rates` keeps.

use crate::error::ControllerError;
use hdrm::DOF;
use serde::{Deserialize, Serialize};

/// Which rates the operator commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RateCommand {
    /// The six joints, by the inputs `rate.joint`.
    #[default]
    Joint,
    /// The tip in the world, by the inputs `rate.tip`.
    Tip,
}

/// Limits of commanded rates; those of the tip limit magnitudes of vectors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RateLimits {
    /// Joint rates, rad/s, under commands of the tip too.
    pub joint: [f64; DOF],
    /// Joint accelerations, rad/s², under commands of the tip too.
    pub joint_acceleration: [f64; DOF],
    /// Velocity, m/s, and angular velocity of the tip, rad/s.
    pub tip: [f64; 2],
    /// Accelerations under commands of the tip, m/s² and rad/s².
    pub tip_acceleration: [f64; 2],
    /// Time constant τ with which rates follow commands, s.
    pub smoothing: f64,
}

impl Default for RateLimits {
    /// Some 70 mm/s of the reference machine's rods, reached within a second. With less smoothing
    /// the drives lag so much that wrist joints exceed their rates by a tenth.
    fn default() -> Self {
        Self {
            joint: [0.15, 0.1, 0.1, 0.5, 0.5, 0.5],
            joint_acceleration: [0.3, 0.2, 0.2, 1.0, 1.0, 1.0],
            tip: [0.25, 0.3],
            tip_acceleration: [0.6, 1.0],
            smoothing: 0.2,
        }
    }
}

impl RateLimits {
    pub(crate) fn check(&self) -> Result<(), ControllerError> {
        let [joint, joint_acceleration] = [&self.joint, &self.joint_acceleration];
        let rows: [(&'static str, &[f64]); 5] = [
            ("rate.joint_max", joint),
            ("rate.joint_acceleration_max", joint_acceleration),
            ("rate.tip_max", &self.tip),
            ("rate.tip_acceleration_max", &self.tip_acceleration),
            ("rate.smoothing", std::slice::from_ref(&self.smoothing)),
        ];
        for (name, values) in rows {
            if let Some(&value) = values.iter().find(|x| !(x.is_finite() && **x > 0.0)) {
                return Err(ControllerError::RateLimit { name, value });
            }
        }
        Ok(())
    }

    /// Largest speed from which a joint can stop within `ahead` with the deceleration `a`:
    /// `√((a·T)² + 2·a·ahead) − a·T`. Close to the end it is `ahead/T`; T = 4τ is the smallest for
    /// which the smoothed rate does not oscillate there (roots −1, −0.38, −2.6 times 1/τ).
    pub(crate) fn speed_before(&self, ahead: f64, a: f64) -> f64 {
        let lag = 4.0 * self.smoothing * a;
        let ahead = ahead.max(0.0);
        (lag * lag + 2.0 * a * ahead).sqrt() - lag
    }
}
