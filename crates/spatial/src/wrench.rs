//! Wrenches: forces and moments on rigid bodies, and momenta.

use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// A wrench `[f; m]` in and about some frame A (`[paper] Eq. (Eq:Force_Moment)`); also a spatial
/// momentum (linear, angular about the origin).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub f: Vector3<f64>,
    /// Moment about the frame's origin, N·m.
    pub m: Vector3<f64>,
}

impl Wrench {
    /// No force, no moment.
    #[must_use]
    pub fn zero() -> Self {
        Self::default()
    }

    /// From force and moment.
    #[must_use]
    pub const fn new(f: Vector3<f64>, m: Vector3<f64>) -> Self {
        Self { f, m }
    }

    /// `[f; m]` as one column.
    #[must_use]
    pub fn to_vector(&self) -> Vector6<f64> {
        let (f, m) = (self.f, self.m);
        Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z)
    }

    /// From the column `[f; m]`.
    #[must_use]
    pub fn from_vector(c: &Vector6<f64>) -> Self {
        Self::new(c.fixed_rows::<3>(0).into(), c.fixed_rows::<3>(3).into())
    }
}

impl Add for Wrench {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.f + other.f, self.m + other.m)
    }
}

impl AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Wrench {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.f - other.f, self.m - other.m)
    }
}

impl SubAssign for Wrench {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Neg for Wrench {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.f, -self.m)
    }
}

impl Mul<f64> for Wrench {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self::new(self.f * s, self.m * s)
    }
}
