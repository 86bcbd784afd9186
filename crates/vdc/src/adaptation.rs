//! Natural adaptation of a body's inertial parameters ([L adapt], [Df]).
//!
//! The estimate lives on the manifold of physically consistent inertias: its pseudo-inertia
//! `L̂ = [[Σ, h], [hᵀ, m]]` stays positive definite. The law `L̂' = (1/γ)·L̂·S·L̂` is integrated
//! through its inverse, `P = L̂⁻¹`, `P' = −S/γ`: linear, exact while S is held, and without the
//! finite escape time that explicit Euler on L̂ has.

use nalgebra::{Matrix4, Vector3, Vector4};
use serde::{Deserialize, Serialize};
use spatial::{Inertia, PseudoInertia, Twist};

/// Estimated inertia of one body about its frame origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Inverse pseudo-inertia, P = L̂⁻¹.
    P: Matrix4<f64>,
    /// The same estimate as mass, first moment and rotational inertia.
    inertia: Inertia,
}

/// Bounds `lower·P0 < P < upper·P0` (in the order of symmetric matrices) around the start value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Bounds {
    /// Inverse of the nominal pseudo-inertia.
    P0: Matrix4<f64>,
    lower: f64,
    upper: f64,
}

impl Bounds {
    /// Bounds around a nominal inertia.
    pub(crate) fn around(nominal: &Inertia, [lower, upper]: [f64; 2]) -> Option<Self> {
        let P0 = Factor::of(&PseudoInertia::from(nominal).0)?.inverse();
        Some(Self { P0, lower, upper })
    }

    /// The estimate that equals the nominal inertia.
    pub(crate) fn nominal(&self, inertia: Inertia) -> Estimate {
        Estimate {
            P: self.P0,
            inertia,
        }
    }

    fn contain(&self, P: &Matrix4<f64>) -> bool {
        Factor::of(&(P - self.P0 * self.lower)).is_some()
            && Factor::of(&(self.P0 * self.upper - P)).is_some()
    }
}

/// `A = L·D·Lᵀ` of a positive definite 4×4 matrix, L unit lower triangular, D diagonal. Loops of fixed length
/// without square roots: a tenth of the instructions of nalgebra's Cholesky factor for any size.
struct Factor {
    L: Matrix4<f64>,
    D: Vector4<f64>,
}

impl Factor {
    /// Reads the lower triangle; None unless all pivots are positive, which is to say that A is positive definite.
    fn of(A: &Matrix4<f64>) -> Option<Self> {
        let (mut L, mut D) = (*A, Vector4::zeros());
        for j in 0..4 {
            let pivot = L[(j, j)];
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            let inverse = pivot.recip();
            for i in j + 1..4 {
                for k in j + 1..=i {
                    L[(i, k)] -= L[(i, j)] * inverse * L[(k, j)];
                }
            }
            for i in j + 1..4 {
                L[(i, j)] *= inverse;
            }
            D[j] = pivot;
        }
        Some(Self { L, D })
    }

    /// `A⁻¹ = Wᵀ·D⁻¹·W` with `W = L⁻¹`.
    fn inverse(&self) -> Matrix4<f64> {
        let Self { L, D } = self;
        let mut W: Matrix4<f64> = Matrix4::identity();
        for j in 0..4 {
            for i in j + 1..4 {
                for k in j..i {
                    W[(i, j)] -= L[(i, k)] * W[(k, j)];
                }
            }
        }
        let reciprocals = D.map(f64::recip);
        let mut inverse = Matrix4::zeros();
        for i in 0..4 {
            for j in 0..=i {
                let sum: f64 = (i..4).map(|k| W[(k, i)] * W[(k, j)] * reciprocals[k]).sum();
                inverse[(i, j)] = sum;
                inverse[(j, i)] = sum;
            }
        }
        inverse
    }

    /// `|A|`.
    fn determinant(&self) -> f64 {
        self.D.product()
    }
}

impl Estimate {
    /// Estimated inertia about the frame origin.
    pub(crate) fn inertia(&self) -> &Inertia {
        &self.inertia
    }

    /// Advances by `h` s with S held. A step that would leave the bounds is refused: the estimate
    /// stays, which only removes adaptation along S and keeps the Lyapunov argument (the true
    /// parameters lie inside).
    pub(crate) fn advance(&mut self, S: &Matrix4<f64>, gamma: f64, h: f64, bounds: &Bounds) {
        let P = self.P - S * (h / gamma);
        if !bounds.contain(&P) {
            return;
        }
        if let Some(factor) = Factor::of(&P) {
            self.inertia = (&PseudoInertia(factor.inverse())).into();
            self.P = P;
        }
    }

    /// Bregman divergence of the true inertia from the estimate ([Df]), ≥ 0, zero if equal:
    /// `D(L‖L̂) = log(|L̂|/|L|) + tr(L̂⁻¹·L) − 4`; not a number if either is no physical body.
    pub(crate) fn divergence(&self, truth: &Inertia) -> f64 {
        let L = PseudoInertia::from(truth).0;
        let determinant = |A| Factor::of(A).map_or(f64::NAN, |factor| factor.determinant());
        // tr(P·L) of two symmetric matrices is the sum over equal places.
        self.P.dot(&L) - 4.0 - (determinant(&self.P) * determinant(&L)).ln()
    }
}

/// The unique symmetric matrix with `tr(f(θ~)·S) = θ~ᵀ·Yᵀ·s`:
/// `S = sym(ŵᵀ·ŝ) − sym(V̂_rᵀ·[V × s]^)`, with `w = V_r' + V × V_r − a_g` and û the 4×4 form of a
/// twist.
pub(crate) fn adaptation_direction(w: &Twist, V_r: &Twist, V: &Twist, s: &Twist) -> Matrix4<f64> {
    symmetric_product(w, s) - symmetric_product(V_r, &V.crm(s))
}

/// `sym(âᵀ·b̂)`: with ρ = (x; 1) the integral of (âρ)·(b̂ρ) over a body is `tr(L·sym(âᵀ·b̂))`.
fn symmetric_product(a: &Twist, b: &Twist) -> Matrix4<f64> {
    let outer = b.w * a.w.transpose();
    let rotation =
        nalgebra::Matrix3::from_diagonal_element(a.w.dot(&b.w)) - (outer + outer.transpose()) * 0.5;
    let mixed: Vector3<f64> = (a.w.cross(&b.v) + b.w.cross(&a.v)) * -0.5;
    let mut product = Matrix4::zeros();
    product.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    product.fixed_view_mut::<3, 1>(0, 3).copy_from(&mixed);
    product
        .fixed_view_mut::<1, 3>(3, 0)
        .copy_from(&mixed.transpose());
    product[(3, 3)] = a.v.dot(&b.v);
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    /// Reproducible numbers in (−1, 1).
    fn noise(k: usize, j: usize) -> f64 {
        (12.9898 * k as f64 + 78.233 * j as f64).sin()
    }

    fn twist(k: usize, j: usize) -> Twist {
        let v = |o: usize| Vector3::new(noise(k, j + o), noise(k, j + o + 1), noise(k, j + o + 2));
        Twist::new(v(0) * 3.0, v(3) * 2.0)
    }

    fn inertia(k: usize) -> Inertia {
        let d = Vector3::new(1.3, 1.1, 0.7)
            + Vector3::new(noise(k, 40), noise(k, 41), noise(k, 42)) * 0.2;
        let com = Vector3::new(noise(k, 43), noise(k, 44), noise(k, 45));
        Inertia::from_com(
            20.0 + 9.0 * noise(k, 46),
            com,
            Matrix3::from_diagonal(&d) * 30.0,
        )
    }

    /// tr(f(θ~)·S) = sᵀ·Y·θ~ with Y·θ~ by the body's dynamics, which share no code with S.
    /// Tolerance: some 60 rounded products of the largest magnitude involved.
    #[test]
    fn S_reproduces_the_regressor_identity() {
        for k in 0..1000 {
            let (w, V_r, V, s) = (twist(k, 1), twist(k, 8), twist(k, 15), twist(k, 22));
            let theta = inertia(k);
            let L = PseudoInertia::from(&theta).0;
            let left = (L * adaptation_direction(&w, &V_r, &V, &s)).trace();
            let right = s.power(&(theta.apply(&w) + V.crf(&theta.apply(&V_r))));
            let size = |t: &Twist| t.v.norm() + t.w.norm();
            let scale = theta.to_matrix().norm() * size(&s) * (size(&w) + size(&V) * size(&V_r));
            let error = (left - right).abs();
            assert!(
                error < 60.0 * f64::EPSILON * scale,
                "k = {k}: {left} vs {right}"
            );
        }
    }

    /// The Coriolis form of the controller, C·u = I·(V×u) + V×*(I·u), is skew: sᵀ·C·s = 0.
    #[test]
    fn the_coriolis_form_is_skew() {
        for k in 0..1000 {
            let (V, s, theta) = (twist(k, 1), twist(k, 8), inertia(k));
            let C_s = theta.apply(&V.crm(&s)) + V.crf(&theta.apply(&s));
            let scale = theta.to_matrix().norm()
                * (s.v.norm() + s.w.norm()).powi(2)
                * (V.v.norm() + V.w.norm());
            assert!(s.power(&C_s).abs() < 60.0 * f64::EPSILON * scale, "k = {k}");
        }
    }

    /// With S held the inverse is linear in time: many small steps equal one large one.
    /// Tolerance: one rounding of P per step.
    #[test]
    fn integration_of_the_inverse_is_exact_for_held_S() {
        let nominal = inertia(3);
        let bounds = Bounds::around(&nominal, [0.2, 5.0]).expect("physical");
        let S =
            adaptation_direction(&twist(0, 1), &twist(0, 8), &twist(0, 15), &twist(0, 22)) * 1e-3;
        let (mut once, mut often) = (bounds.nominal(nominal), bounds.nominal(nominal));
        once.advance(&S, 50.0, 0.25, &bounds);
        for _ in 0..256 {
            often.advance(&S, 50.0, 0.25 / 256.0, &bounds);
        }
        assert_ne!(once.inertia(), &nominal, "the step must change something");
        let error = (once.P - often.P).norm() / once.P.norm();
        assert!(error < 256.0 * f64::EPSILON, "{error:e}");
    }

    /// Under any S the estimate stays physical and inside its bounds.
    #[test]
    fn the_estimate_stays_inside_its_bounds() {
        let nominal = inertia(5);
        let bounds = Bounds::around(&nominal, [0.2, 5.0]).expect("physical");
        let mut estimate = bounds.nominal(nominal);
        let mut moved = false;
        for k in 0..20_000 {
            let S = adaptation_direction(&twist(k, 1), &twist(k, 8), &twist(k, 15), &twist(k, 22));
            estimate.advance(&S, 5.0, 1e-3, &bounds);
            moved |= estimate.inertia() != &nominal;
            assert!(bounds.contain(&estimate.P), "step {k}");
            assert!(estimate.inertia().m > 0.0, "step {k}");
        }
        assert!(moved);
    }

    #[test]
    fn the_divergence_is_zero_for_the_truth_and_positive_elsewhere() {
        let nominal = inertia(7);
        let bounds = Bounds::around(&nominal, [0.2, 5.0]).expect("physical");
        let estimate = bounds.nominal(nominal);
        // Tolerance: condition of L (some 1e3) times ε.
        assert!(estimate.divergence(&nominal).abs() < 1e-12);
        // Closed form for L = c·L̂: 4(c − 1 − ln c).
        let c: f64 = 1.4;
        let expected = 4.0 * (c - 1.0 - c.ln());
        assert!((estimate.divergence(&(nominal * c)) - expected).abs() < 1e-12);
    }
}
