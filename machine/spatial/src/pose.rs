//! Pose of one frame in another, and changes of frame, for the recursions of plant and controller.

use crate::{Inertia, Twist, Wrench};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use std::ops::Mul;

/// `X_AB`: pose of frame B in frame A, the content of the paper's `ᴬU_B`
/// (`[paper] Eq. (Eq:Transformation_Matrix)`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Rotation matrix `ᴬR_B` from B to A.
    pub R: Matrix3<f64>,
    /// From the origin of A to the origin of B, in A axes, m.
    pub r: Vector3<f64>,
}

impl Default for Pose {
    fn default() -> Self {
        Self::identity()
    }
}

/// `X_AC = X_AB · X_BC`.
impl Mul for Pose {
    type Output = Self;
    fn mul(self, X_BC: Self) -> Self {
        Self {
            R: self.R * X_BC.R,
            r: self.r + self.R * X_BC.r,
        }
    }
}

impl Pose {
    /// A and B coincide.
    pub fn identity() -> Self {
        Self::translation(Vector3::zeros())
    }

    /// B is A shifted by `r`.
    pub fn translation(r: Vector3<f64>) -> Self {
        let R = Matrix3::identity();
        Self { R, r }
    }

    /// Shifted by `r`, then turned about x by the angle with cosine `c` and sine `s`.
    pub fn turn_x(r: Vector3<f64>, c: f64, s: f64) -> Self {
        let R = Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
        Self { R, r }
    }

    /// Shifted by `r`, then turned about y by the angle with cosine `c` and sine `s`.
    pub fn turn_y(r: Vector3<f64>, c: f64, s: f64) -> Self {
        let R = Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c);
        Self { R, r }
    }

    /// Shifted by `r`, then turned about z by the angle with cosine `c` and sine `s`.
    pub fn turn_z(r: Vector3<f64>, c: f64, s: f64) -> Self {
        let R = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
        Self { R, r }
    }

    /// `X_BA`.
    pub fn inverse(&self) -> Self {
        let R = self.R.transpose();
        Self {
            R,
            r: -(R * self.r),
        }
    }

    /// `ᴮV = ᴬU_Bᵀ ᴬV` for a frame B rigidly attached to A (`[paper] Eq. (Eq:Transformation)`).
    pub fn twist_to_B(&self, V_A: &Twist) -> Twist {
        Twist {
            v: self.R.tr_mul(&(V_A.v + V_A.w.cross(&self.r))),
            w: self.R.tr_mul(&V_A.w),
        }
    }

    /// The same twist seen from A, the inverse of [`Pose::twist_to_B`].
    pub fn twist_to_A(&self, V_B: &Twist) -> Twist {
        let w = self.R * V_B.w;
        Twist {
            v: self.R * V_B.v - w.cross(&self.r),
            w,
        }
    }

    /// `ᴬF = ᴬU_B ᴮF` (`[paper] Eq. (Eq:Transformation)`).
    pub fn wrench_to_A(&self, F_B: &Wrench) -> Wrench {
        let f = self.R * F_B.f;
        Wrench {
            f,
            m: self.R * F_B.m + self.r.cross(&f),
        }
    }

    /// The inertia of a body given in B, seen from A.
    pub fn inertia_to_A(&self, I_B: &Inertia) -> Inertia {
        I_B.rotated(&self.R).shifted(&self.r)
    }
}
