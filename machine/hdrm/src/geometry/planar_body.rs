//! Spatial algebra for bodies that move in a plane which rotates about y, without the entries that
//! are always zero; `boom_frame` computes the dynamics with it.
//!
//! Frame P rotates with the rate w_1 about y through its origin. A planar body moves relative to P
//! with `(v_x, v_y, w_z)` at P's origin. Of its net wrench only `f_x, f_y, m_z` (planar motion) and
//! `m_y` (slew) do work. All quantities are in and about P; the mass distribution is general
//! (centre of mass off the plane, any products of inertia).

use crate::geometry::planar::perp;
use nalgebra::{Vector2, Vector3};
use spatial::{Inertia, Twist, Wrench};
use std::ops::{Add, Mul};

macro_rules! sum_by_field {
    ($type:ident: $($field:ident)*) => {
        impl Add for $type {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self { $($field: self.$field + other.$field),* }
            }
        }
    };
}

sum_by_field!(PlanarTwist: v w);
sum_by_field!(PlanarWrench: f m_y m_z);
sum_by_field!(PlanarInertia: m h yy zz xy xz yz);

/// Twist relative to P: velocity at P's origin and turning rate about z.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PlanarTwist {
    pub v: Vector2<f64>,
    pub w: f64,
}

impl PlanarTwist {
    /// Unit turn about z through the point `r`: `v = w×(0 − r) = −⊥r`.
    pub fn turn(r: Vector2<f64>) -> Self {
        Self {
            v: -perp(r),
            w: 1.0,
        }
    }

    /// Unit slide along `e`.
    pub fn slide(e: Vector2<f64>) -> Self {
        Self { v: e, w: 0.0 }
    }

    /// `crm(V)·T` in the plane.
    fn crm(self, T: Self) -> Self {
        Self {
            v: perp(T.v) * self.w - perp(self.v) * T.w,
            w: 0.0,
        }
    }

    /// `Vᵀ F`.
    pub fn power(self, F: PlanarWrench) -> f64 {
        self.v.dot(&F.f) + self.w * F.m_z
    }
}

impl Mul<f64> for PlanarTwist {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self {
            v: self.v * s,
            w: self.w * s,
        }
    }
}

/// The components of a wrench (or momentum) that do work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PlanarWrench {
    pub f: Vector2<f64>,
    pub m_y: f64,
    pub m_z: f64,
}

impl From<Wrench> for PlanarWrench {
    fn from(F: Wrench) -> Self {
        Self {
            f: F.f.xy(),
            m_y: F.m.y,
            m_z: F.m.z,
        }
    }
}

/// Twist relative to P and its rate in P with all `zeta_ddot = 0`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PlanarMotion {
    pub V: PlanarTwist,
    pub A: PlanarTwist,
}

impl PlanarMotion {
    /// Twist against the ground and acceleration minus gravity, in P:
    /// `V = [v; w_1 y + w z]`, `A = [a; α z] + crm([0; w_1 y])·[v; w z] − a_g`, `a_g = −g y`.
    pub fn spatial(&self, w_1: f64, g: f64) -> (Twist, Twist) {
        let Self { V, A } = self;
        (
            Twist::new(V.v.push(0.0), Vector3::new(0.0, w_1, V.w)),
            Twist::new(
                Vector3::new(A.v.x, A.v.y + g, -w_1 * V.v.x),
                Vector3::new(w_1 * V.w, 0.0, A.w),
            ),
        )
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct PlanarJoint {
    /// Twist of the body against its parent for a unit rate of the coordinate, `s·g`.
    pub S: PlanarTwist,
    /// `s·g′`.
    pub S_prime: PlanarTwist,
}

impl PlanarJoint {
    /// Joint with unit twist `s`, gear g and its derivative g′.
    pub fn new(s: PlanarTwist, [gear, gear_prime, _]: [f64; 3]) -> Self {
        Self {
            S: s * gear,
            S_prime: s * gear_prime,
        }
    }

    /// A joint that turns about `r` with its coordinate.
    pub fn turn(r: Vector2<f64>) -> Self {
        Self::new(PlanarTwist::turn(r), [1.0, 0.0, 0.0])
    }

    /// Motion of the body: `V = V_p + S·w`, `A = A_p + S′·w² + crm(V)·S·w`.
    pub fn child(&self, parent: &PlanarMotion, rate: f64) -> PlanarMotion {
        let V = parent.V + self.S * rate;
        PlanarMotion {
            V,
            A: parent.A + self.S_prime * (rate * rate) + V.crm(self.S * rate),
        }
    }
}

/// Inertia in and about P, without xx, which is never needed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PlanarInertia {
    pub m: f64,
    pub h: Vector3<f64>,
    pub yy: f64,
    pub zz: f64,
    pub xy: f64,
    pub xz: f64,
    pub yz: f64,
}

impl From<&Inertia> for PlanarInertia {
    fn from(body: &Inertia) -> Self {
        let I = &body.I;
        Self {
            m: body.m,
            h: body.h,
            yy: I[(1, 1)],
            zz: I[(2, 2)],
            xy: I[(0, 1)],
            xz: I[(0, 2)],
            yz: I[(1, 2)],
        }
    }
}

impl PlanarInertia {
    /// A body given in its own axes, which are rotated about z by the angle of `e` and shifted by
    /// `r` in P: `R I Rᵀ`, then the shift of [`Inertia::shifted`].
    // Inlined for each of the eight bodies, this and `net_wrench` exceed the processor's cache of
    // decoded instructions.
    #[inline(never)]
    pub fn placed(body: &Inertia, e: Vector2<f64>, r: Vector3<f64>) -> Self {
        let (c, s) = (e.x, e.y);
        let Inertia { m, h, I } = body;
        let (xx, yy, zz) = (I[(0, 0)], I[(1, 1)], I[(2, 2)]);
        let (xy, xz, yz) = (I[(0, 1)], I[(0, 2)], I[(1, 2)]);
        let h = Vector3::new(c * h.x - s * h.y, s * h.x + c * h.y, h.z);
        // r hᵀ + h rᵀ + m r rᵀ = r kᵀ + k rᵀ with k = h + m r / 2
        let k = h + r * (0.5 * m);
        Self {
            m: *m,
            h: h + r * *m,
            yy: s * s * xx + 2.0 * c * s * xy + c * c * yy + 2.0 * (r.x * k.x + r.z * k.z),
            zz: zz + 2.0 * (r.x * k.x + r.y * k.y),
            xy: c * s * (xx - yy) + (c * c - s * s) * xy - (r.x * k.y + r.y * k.x),
            xz: c * xz - s * yz - (r.x * k.z + r.z * k.x),
            yz: s * xz + c * yz - (r.y * k.z + r.z * k.y),
        }
    }

    /// Momentum `M·V` of a motion in the plane.
    pub fn apply(&self, V: PlanarTwist) -> PlanarWrench {
        let Self { m, h, .. } = self;
        PlanarWrench {
            f: V.v * *m + perp(h.xy()) * V.w,
            m_y: self.yz * V.w + h.z * V.v.x,
            m_z: self.zz * V.w + h.x * V.v.y - h.y * V.v.x,
        }
    }

    /// [`Inertia::net_wrench`] `M·A + crf(V)·M·V` of [`PlanarMotion::spatial`], expanded.
    #[inline(never)] // see `placed`
    pub fn net_wrench(&self, motion: &PlanarMotion, w_1: f64, g: f64) -> PlanarWrench {
        let Self { m, h, .. } = self;
        let PlanarMotion { V, A } = motion;
        let (v, w) = (V.v, V.w);
        // A = [a_x, a_y, a_z; alpha_x, 0, A.w]
        let (a_x, a_y, a_z) = (A.v.x, A.v.y + g, -w_1 * v.x);
        let alpha_x = w_1 * w;
        // Momentum p = m v + w×h and the x part of L = I w + h×v
        let p_x = m * v.x + w_1 * h.z - w * h.y;
        let p_y = m * v.y + w * h.x;
        let p_z = -w_1 * h.x;
        let L_x = self.xy * w_1 + self.xz * w - h.z * v.y;
        PlanarWrench {
            f: Vector2::new(
                m * a_x - A.w * h.y + w_1 * p_z - w * p_y,
                m * a_y + A.w * h.x - alpha_x * h.z + w * p_x,
            ),
            m_y: self.xy * alpha_x + self.yz * A.w + h.z * a_x - h.x * a_z + w * L_x - v.x * p_z,
            m_z: self.xz * alpha_x + self.zz * A.w + h.x * a_y - h.y * a_x - w_1 * L_x + v.x * p_y
                - v.y * p_x,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    /// Two bodies in one frame have the inertia of their sum.
    #[test]
    fn inertias_add_up_component_by_component() {
        let body = |m: f64| {
            let h = Vector3::new(2.0, 3.0, 5.0) * m;
            let I = Matrix3::from_fn(|i, j| m * [7.0, 11.0, 13.0][i] * [7.0, 11.0, 13.0][j]);
            Inertia { m, h, I }
        };
        let (a, b) = (body(3.0), body(4.0));
        let sum = PlanarInertia::from(&a) + PlanarInertia::from(&b);
        assert_eq!(
            format!("{sum:?}"),
            format!("{:?}", PlanarInertia::from(&(a + b)))
        );
    }
}
