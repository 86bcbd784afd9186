//! Spatial inertia of a rigid body, for plant, controller and studies: mass, first moment and
//! rotational inertia in a frame, and how they change with the frame.

use crate::{Twist, Wrench};
use nalgebra::{Matrix3, Matrix6, Vector3};
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Mul};

/// The ten inertial parameters of a body in some frame A, the paper's `θ_A = (m, h, I)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inertia {
    /// Mass, kg.
    pub m: f64,
    /// First moment of mass, `m·r_com`, kg·m.
    pub h: Vector3<f64>,
    /// Rotational inertia about the frame's origin, kg·m².
    pub I: Matrix3<f64>,
}

impl Inertia {
    /// From mass, centre of mass and the inertia `I_com` about the centre of mass:
    /// `I = I_com + m·(|r|²·1 − r rᵀ)`.
    pub fn from_com(m: f64, com: Vector3<f64>, I_com: Matrix3<f64>) -> Self {
        Self {
            m,
            h: Vector3::zeros(),
            I: I_com,
        }
        .shifted(&com)
    }

    /// The same body in other axes with the same origin; `R` turns vectors to the new axes.
    pub fn rotated(&self, R: &Matrix3<f64>) -> Self {
        Self {
            m: self.m,
            h: R * self.h,
            I: R * self.I * R.transpose(),
        }
    }

    /// The same body about an origin from which the old one is at `r`:
    /// `h' = h + m·r`, `I' = I + (2 r·h + m|r|²)·1 − (r hᵀ + h rᵀ + m r rᵀ)`.
    pub fn shifted(&self, r: &Vector3<f64>) -> Self {
        let Self { m, h, I } = *self;
        let half = h + r * (0.5 * m);
        let cross = r * half.transpose();
        let diagonal = Matrix3::from_diagonal_element(2.0 * r.dot(&half));
        Self {
            m,
            h: h + r * m,
            I: I + diagonal - cross - cross.transpose(),
        }
    }

    /// Momentum `M·V` of the body moving with `V`, also its inertial wrench for an acceleration:
    /// `[m v + w×h; I w + h×v]`.
    pub fn apply(&self, V: &Twist) -> Wrench {
        Wrench {
            f: V.v * self.m + V.w.cross(&self.h),
            m: self.I * V.w + self.h.cross(&V.v),
        }
    }

    /// Net wrench `F* = M·A + crf(V)·M·V` (`[paper] Eq. (Eq:Net_Force)`); gravity enters as the
    /// acceleration `−a_g` of the base inside `A`.
    pub fn net_wrench(&self, V: &Twist, A: &Twist) -> Wrench {
        self.apply(A) + V.crf(&self.apply(V))
    }

    /// The 6×6 matrix `M` with `M·V = apply(V)`, `[v; w]` order.
    pub fn to_matrix(&self) -> Matrix6<f64> {
        let h_cross = self.h.cross_matrix();
        let mut M = Matrix6::from_diagonal_element(self.m);
        M.fixed_view_mut::<3, 3>(0, 3).copy_from(&-h_cross);
        M.fixed_view_mut::<3, 3>(3, 0).copy_from(&h_cross);
        M.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.I);
        M
    }
}

/// Two bodies fixed to each other, in the same frame.
impl Add for Inertia {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            m: self.m + other.m,
            h: self.h + other.h,
            I: self.I + other.I,
        }
    }
}

impl AddAssign for Inertia {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// All masses scaled by the same factor.
impl Mul<f64> for Inertia {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self {
            m: self.m * s,
            h: self.h * s,
            I: self.I * s,
        }
    }
}
