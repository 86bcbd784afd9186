//! Twists: velocities, accelerations and joint axes of rigid bodies.

use crate::Wrench;
use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

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
    /// The twist of a body at rest.
    #[must_use]
    pub fn zero() -> Self {
        Self::default()
    }

    /// From linear and angular part.
    #[must_use]
    pub const fn new(v: Vector3<f64>, w: Vector3<f64>) -> Self {
        Self { v, w }
    }

    /// `[v; w]` as one column.
    #[must_use]
    pub fn to_vector(&self) -> Vector6<f64> {
        let (v, w) = (self.v, self.w);
        Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    }

    /// From the column `[v; w]`.
    #[must_use]
    pub fn from_vector(c: &Vector6<f64>) -> Self {
        Self::new(c.fixed_rows::<3>(0).into(), c.fixed_rows::<3>(3).into())
    }

    /// Power of a wrench on this twist, `fᵀv + mᵀw`, W.
    #[must_use]
    pub fn power(&self, F: &Wrench) -> f64 {
        self.v.dot(&F.f) + self.w.dot(&F.m)
    }

    /// Motion cross product: `crm(V)·T = [w×T.v + v×T.w; w×T.w]`, the rate of a twist `T` that is
    /// carried along by a frame moving with `self`.
    #[must_use]
    pub fn crm(&self, T: &Twist) -> Twist {
        Twist {
            v: self.w.cross(&T.v) + self.v.cross(&T.w),
            w: self.w.cross(&T.w),
        }
    }

    /// Force cross product: `crf(V)·F = [w×f; w×m + v×f] = −crm(V)ᵀ·F`, the rate of a wrench `F`
    /// that is carried along by a frame moving with `self`.
    #[must_use]
    pub fn crf(&self, F: &Wrench) -> Wrench {
        Wrench {
            f: self.w.cross(&F.f),
            m: self.w.cross(&F.m) + self.v.cross(&F.f),
        }
    }
}

impl Add for Twist {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.v + other.v, self.w + other.w)
    }
}

impl AddAssign for Twist {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Twist {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.v - other.v, self.w - other.w)
    }
}

impl SubAssign for Twist {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Neg for Twist {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.v, -self.w)
    }
}

impl Mul<f64> for Twist {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self::new(self.v * s, self.w * s)
    }
}
