//! Twists for plant and controller: velocities, accelerations, joint axes, and cross products.

use crate::Wrench;
use crate::pair::pair_of_vectors;
use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// A twist `[v; w]` in and about some frame A (`[paper] Eq. (Eq:linear_angular)`); also its
/// time derivative in the moving frame (the spatial acceleration), and a joint axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Velocity of the frame's origin, m/s.
    pub v: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub w: Vector3<f64>,
}

impl Twist {
    /// Power of a wrench on this twist, `fᵀv + mᵀw`, W.
    pub fn power(&self, F: &Wrench) -> f64 {
        self.v.dot(&F.f) + self.w.dot(&F.m)
    }

    /// Motion cross product: `crm(V)·T = [w×T.v + v×T.w; w×T.w]`, the rate of a twist `T` that is
    /// carried along by a frame moving with `self`.
    pub fn crm(&self, T: &Twist) -> Twist {
        Twist {
            v: self.w.cross(&T.v) + self.v.cross(&T.w),
            w: self.w.cross(&T.w),
        }
    }

    /// Force cross product: `crf(V)·F = [w×f; w×m + v×f] = −crm(V)ᵀ·F`, the rate of a wrench `F`
    /// that is carried along by a frame moving with `self`.
    pub fn crf(&self, F: &Wrench) -> Wrench {
        Wrench {
            f: self.w.cross(&F.f),
            m: self.w.cross(&F.m) + self.v.cross(&F.f),
        }
    }
}

pair_of_vectors!(Twist: v w, zero: "The twist of a body at rest.");
