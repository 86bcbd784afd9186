//! Plane geometry of the closed loops, for `lift`, `tilt`, `tree` and `boom_frame`: a vector that
//! depends on one joint angle, in polar form, with exact derivatives.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// Derivatives of first, second and third order with respect to one joint angle.
pub type Derivatives<T> = [T; 3];

/// A planar vector `p(ζ) = c·e(ψ)`, `e(ψ) = (cos ψ, sin ψ)`, and its exact derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Polar {
    /// Unit vector e(ψ).
    pub e: Vector2<f64>,
    /// Length c, m.
    pub length: f64,
    /// c′, c″, c‴ with respect to ζ, m/rad^n.
    pub length_d: Derivatives<f64>,
    /// ψ′, ψ″, ψ‴ with respect to ζ, rad/rad^n.
    pub angle_d: Derivatives<f64>,
}

impl Polar {
    /// From the vector and its Cartesian derivatives; with `n = ⊥e`
    /// ```text
    /// p′ = c′ e + cψ′ n
    /// p″ = (c″ − cψ′²) e + (cψ″ + 2c′ψ′) n
    /// p‴ = (c‴ − 3c′ψ′² − 3cψ′ψ″) e + (cψ‴ + 3c″ψ′ + 3c′ψ″ − cψ′³) n
    /// ```
    /// solved for the derivatives of c and ψ. Valid for `c > 0`.
    pub fn new(p: Vector2<f64>, [p1, p2, p3]: Derivatives<Vector2<f64>>) -> Self {
        let c = p.norm();
        let inv_c = c.recip();
        let e = p * inv_c;
        let n = perp(e);
        let c1 = e.dot(&p1);
        let a1 = n.dot(&p1) * inv_c;
        let c2 = e.dot(&p2) + c * a1 * a1;
        let a2 = (n.dot(&p2) - 2.0 * c1 * a1) * inv_c;
        let c3 = e.dot(&p3) + 3.0 * (c1 * a1 * a1 + c * a1 * a2);
        let a3 = (n.dot(&p3) - 3.0 * (c2 * a1 + c1 * a2)) * inv_c + a1 * a1 * a1;
        Self {
            e,
            length: c,
            length_d: [c1, c2, c3],
            angle_d: [a1, a2, a3],
        }
    }
}

/// `⊥a`: turned by +90°.
pub(crate) fn perp(a: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-a.y, a.x)
}

/// The vector turned by the angle whose unit vector is `e`.
pub(crate) fn turned(a: Vector2<f64>, e: Vector2<f64>) -> Vector2<f64> {
    a * e.x + perp(a) * e.y
}

/// e(ψ).
pub(crate) fn unit(psi: f64) -> Vector2<f64> {
    let (s, c) = libm::sincos(psi);
    Vector2::new(c, s)
}

/// `p` and its derivatives by the angle it is turned by: `⊥p, −p, −⊥p`.
pub(crate) fn turning(p: Vector2<f64>) -> Derivatives<Vector2<f64>> {
    [perp(p), -p, -perp(p)]
}

/// `e(a)` seen from axes turned by the angle whose unit vector is `e_b`: e(a − b).
pub(crate) fn relative(e_a: Vector2<f64>, e_b: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(e_b.dot(&e_a), e_b.perp(&e_a))
}
