//! Natural adaptation of a body's inertia ([L adapt], [Df]), for the adaptive law and the proof.
//!
//! The estimate lives on the manifold of physically consistent inertias: its pseudo-inertia
//! `L̂ = [[Σ, h], [hᵀ, m]]` stays positive definite. The law `L̂' = (1/γ)·L̂·S·L̂` is integrated
//! through its inverse, `P = L̂⁻¹`, `P' = −S/γ`: linear, exact while S is held, and without the
//! finite escape time that explicit Euler on L̂ has.

use nalgebra::{Matrix4, SVector};
use serde::{Deserialize, Serialize};
use spatial::{Inertia, PseudoInertia, Twist};

/// A symmetric 4×4 matrix: its lower triangle, column by column.
type Symmetric = SVector<f64, 10>;

#[rustfmt::skip] // one column a line
fn packed(A: &Matrix4<f64>) -> Symmetric {
    [
        A.m11, A.m21, A.m31, A.m41,
        A.m22, A.m32, A.m42,
        A.m33, A.m43,
        A.m44,
    ].into()
}

fn unpacked(A: &Symmetric) -> Matrix4<f64> {
    let [a11, a21, a31, a41, a22, a32, a42, a33, a43, a44] = (*A).into();
    Matrix4::new(
        a11, a21, a31, a41, a21, a22, a32, a42, a31, a32, a33, a43, a41, a42, a43, a44,
    )
}

/// `tr(A·B)`: elements off the diagonal count twice.
fn trace_of_product(A: &Symmetric, B: &Symmetric) -> f64 {
    let AB = A.component_mul(B);
    let diagonal = AB[0] + AB[4] + AB[7] + AB[9];
    2.0 * AB.sum() - diagonal
}

/// Estimated inertia of one body about its frame origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Inverse pseudo-inertia, P = L̂⁻¹.
    P: Symmetric,
    /// |P|.
    determinant: f64,
    /// The same estimate as mass, first moment and rotational inertia.
    inertia: Inertia,
}

/// Bounds `lower·P0 < P < upper·P0` (in the order of symmetric matrices) around the start value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Bounds {
    /// Inverse of the nominal pseudo-inertia.
    P0: Symmetric,
    lower: f64,
    upper: f64,
}

impl Bounds {
    /// Bounds around a nominal inertia; None if it is not physically consistent.
    pub(crate) fn around(nominal: &Inertia, [lower, upper]: [f64; 2]) -> Option<Self> {
        let L = packed(&PseudoInertia::from(nominal).0);
        let minors = Minors::new(&L);
        minors.are_positive().then(|| Self {
            P0: minors.inverse(),
            lower,
            upper,
        })
    }

    /// The estimate that equals the nominal inertia.
    pub(crate) fn nominal(&self, inertia: Inertia) -> Estimate {
        Estimate {
            P: self.P0,
            determinant: Minors::new(&self.P0).determinant(),
            inertia,
        }
    }

    fn contain(&self, P: &Symmetric) -> bool {
        Minors::new(&(P - self.P0 * self.lower)).are_positive()
            && Minors::new(&(self.P0 * self.upper - P)).are_positive()
    }
}

/// A symmetric 4×4 matrix A and its 2×2 minors: determinant and inverse by Laplace's expansion with
/// a single division, positive definiteness by the signs of the leading minors.
struct Minors<'a> {
    A: &'a Symmetric,
    /// Minors of rows 1, 2 and columns 12, 13, 14, 23, 24, 34.
    s: [f64; 6],
    /// Minors of rows 3, 4 and the same columns.
    c: [f64; 6],
}

impl<'a> Minors<'a> {
    fn new(A: &'a Symmetric) -> Self {
        let [a11, a21, a31, a41, a22, a32, a42, a33, a43, a44] = (*A).into();
        let of_rows = |x: [f64; 4], y: [f64; 4]| {
            [
                x[0] * y[1] - x[1] * y[0],
                x[0] * y[2] - x[2] * y[0],
                x[0] * y[3] - x[3] * y[0],
                x[1] * y[2] - x[2] * y[1],
                x[1] * y[3] - x[3] * y[1],
                x[2] * y[3] - x[3] * y[2],
            ]
        };
        Self {
            A,
            s: of_rows([a11, a21, a31, a41], [a21, a22, a32, a42]),
            c: of_rows([a31, a32, a33, a43], [a41, a42, a43, a44]),
        }
    }

    fn determinant(&self) -> f64 {
        let Self { s, c, .. } = self;
        s[0] * c[5] - s[1] * c[4] + s[2] * c[3] + s[3] * c[2] - s[4] * c[1] + s[5] * c[0]
    }

    /// The minor of the first three rows and columns.
    fn third(&self) -> f64 {
        let [_, _, a31, _, _, a32, _, a33, ..] = self.A.data.0[0];
        a31 * self.s[3] - a32 * self.s[1] + a33 * self.s[0]
    }

    /// Whether all leading minors are positive, that is, A is positive definite.
    fn are_positive(&self) -> bool {
        self.A[0] > 0.0 && self.s[0] > 0.0 && self.third() > 0.0 && self.determinant() > 0.0
    }

    /// `A⁻¹`: cofactors over the determinant.
    fn inverse(&self) -> Symmetric {
        let Self { A, s, c } = self;
        let [a11, a21, a31, a41, a22, a32, a42, a33, a43, a44] = (**A).into();
        let cofactors = Symmetric::from([
            a22 * c[5] - a32 * c[4] + a42 * c[3],
            a31 * c[4] - a21 * c[5] - a41 * c[3],
            a42 * s[5] - a43 * s[4] + a44 * s[3],
            a33 * s[4] - a32 * s[5] - a43 * s[3],
            a11 * c[5] - a31 * c[2] + a41 * c[1],
            a43 * s[2] - a41 * s[5] - a44 * s[1],
            a31 * s[5] - a33 * s[2] + a43 * s[1],
            a41 * s[4] - a42 * s[2] + a44 * s[0],
            a32 * s[2] - a31 * s[4] - a43 * s[0],
            self.third(),
        ]);
        cofactors * self.determinant().recip()
    }
}

impl Estimate {
    /// Estimated inertia about the frame origin.
    pub(crate) fn inertia(&self) -> &Inertia {
        &self.inertia
    }

    /// The estimate after the nominal inertia has changed from `before` to `after`: changed by the
    /// same difference, or `after` itself if the result is outside the new `bounds`.
    pub(crate) fn moved(&self, before: &Inertia, after: &Inertia, bounds: &Bounds) -> Self {
        let inertia = Inertia {
            m: self.inertia.m + after.m - before.m,
            h: self.inertia.h + after.h - before.h,
            I: self.inertia.I + after.I - before.I,
        };
        let L = packed(&PseudoInertia::from(&inertia).0);
        let minors = Minors::new(&L);
        if minors.are_positive() {
            let P = minors.inverse();
            if bounds.contain(&P) {
                return Self {
                    determinant: Minors::new(&P).determinant(),
                    P,
                    inertia,
                };
            }
        }
        bounds.nominal(*after)
    }

    /// Advances by `h` s with S held. A step that would leave the bounds is skipped as a whole.
    /// Inside the bounds P is positive definite, `P > lower·P0 > 0`.
    ///
    /// This is not a projection that preserves the Lyapunov argument, which needs that the omitted
    /// part of a step never points towards the true parameters, `tr((L − L̂) ΔS) ≤ 0`: a skipped
    /// step omits all of S, which for ten parameters may point either way, and the true body may be
    /// outside the bounds. Then the adaptation's term is `tr(f(θ~) S)`, of either sign.
    ///
    /// `leakage` σ, 1/s, pulls towards the nominal inertia, `P' = −S/γ − σ (P − P0)`, against drift
    /// with inexact measurements (σ-modification of Ioannou and Kokotović); 0 is the paper's law.
    pub(crate) fn advance(
        &mut self,
        S: &Symmetric,
        gamma: f64,
        leakage: f64,
        h: f64,
        bounds: &Bounds,
    ) {
        let mut P = self.P - S * (h / gamma);
        if leakage > 0.0 {
            P += (self.P - bounds.P0) * libm::expm1(-h * leakage);
        }
        if bounds.contain(&P) {
            let minors = Minors::new(&P);
            *self = Self {
                P,
                determinant: minors.determinant(),
                inertia: (&PseudoInertia(unpacked(&minors.inverse()))).into(),
            };
        }
    }

    /// Bregman divergence of the true inertia from the estimate ([Df]), ≥ 0, zero if equal:
    /// `D(L‖L̂) = log(|L̂|/|L|) + tr(L̂⁻¹·L) − 4`; NaN if `truth` is inconsistent.
    pub(crate) fn divergence(&self, truth: &Inertia) -> f64 {
        let L = packed(&PseudoInertia::from(truth).0);
        let log_of_quotient = -libm::log(self.determinant * Minors::new(&L).determinant());
        log_of_quotient + trace_of_product(&self.P, &L) - 4.0
    }
}

/// The unique symmetric matrix with `tr(f(θ~)·S) = θ~ᵀ·Yᵀ·s`:
/// `S = sym(ŵᵀ·ŝ) − sym(V̂_rᵀ·[V × s]^)`, with `w = V_r' + V × V_r − a_g` and û the 4×4 form of a
/// twist.
pub(crate) fn adaptation_direction(w: &Twist, V_r: &Twist, V: &Twist, s: &Twist) -> Symmetric {
    symmetric_product(w, s) - symmetric_product(V_r, &V.crm(s))
}

/// `sym(âᵀ·b̂)`: with ρ = (x; 1) the integral of (âρ)·(b̂ρ) over a body is `tr(L·sym(âᵀ·b̂))`. Its
/// blocks are `(a.w·b.w)·1 − ½(a.w b.wᵀ + b.w a.wᵀ)`, `−½(a.w × b.v + b.w × a.v)` and `a.v·b.v`.
fn symmetric_product(a: &Twist, b: &Twist) -> Symmetric {
    let squares = a.w.component_mul(&b.w);
    let half = |i: usize, j: usize| -0.5 * (a.w[i] * b.w[j] + a.w[j] * b.w[i]);
    let mixed = (a.w.cross(&b.v) + b.w.cross(&a.v)) * -0.5;
    [
        squares.y + squares.z,
        half(1, 0),
        half(2, 0),
        mixed.x,
        squares.x + squares.z,
        half(2, 1),
        mixed.y,
        squares.x + squares.y,
        mixed.z,
        a.v.dot(&b.v),
    ]
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

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
            let left = (L * unpacked(&adaptation_direction(&w, &V_r, &V, &s))).trace();
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

    /// Inverse, determinant and definiteness against what defines them: `A·A⁻¹ = 1`, the product of
    /// the eigenvalues and their signs (nalgebra's QR iteration shares no code). Two matrices of
    /// three are shifted and may have negative ones. Tolerance: a product of four entries and its
    /// sum are rounded 4 times.
    #[test]
    fn minors_give_inverse_determinant_and_definiteness() {
        let (mut definite, mut worst) = (0, 0.0_f64);
        for k in 0..1000 {
            let B = Matrix4::from_fn(|i, j| noise(k, (4 * i + j).pow(2)));
            let shift = [0.0, 0.3, 1.5][k % 3];
            let A = B * B.transpose() - Matrix4::from_diagonal_element(shift);
            let eigenvalues = A.symmetric_eigenvalues();
            let determinant = eigenvalues.product();
            let tolerance =
                4.0 * f64::EPSILON * (eigenvalues.abs().max().powi(4) / determinant).abs();
            let packed = packed(&A);
            let minors = Minors::new(&packed);
            let of_inverse = (A * unpacked(&minors.inverse()) - Matrix4::identity()).norm();
            let of_determinant = (minors.determinant() / determinant - 1.0).abs();
            worst = worst.max(of_inverse.max(of_determinant) / tolerance);
            assert!(worst < 1.0, "k = {k}: {of_inverse:e}, {of_determinant:e}");
            let positive = eigenvalues.iter().all(|&value| value > 0.0);
            assert_eq!(minors.are_positive(), positive, "k = {k}: {eigenvalues}");
            definite += usize::from(positive);
        }
        assert!((340..900).contains(&definite), "{definite}");
        assert!(worst > 0.1, "the tolerance is not sharp: {worst}");
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
        once.advance(&S, 50.0, 0.0, 0.25, &bounds);
        for _ in 0..256 {
            often.advance(&S, 50.0, 0.0, 0.25 / 256.0, &bounds);
        }
        assert_ne!(once.inertia(), &nominal, "the step must change something");
        let error = (once.P - often.P).norm() / once.P.norm();
        assert!(error < 256.0 * f64::EPSILON, "{error:e}");
    }

    /// Closed form: with S = 0 the distance from the nominal decays with e^(−σ t). Tolerance: one
    /// rounding of P per step.
    #[test]
    fn leakage_leads_back_to_the_nominal_inertia() {
        let nominal = inertia(3);
        let bounds = Bounds::around(&nominal, [0.2, 5.0]).expect("physical");
        let mut estimate = bounds.nominal(nominal);
        let S =
            adaptation_direction(&twist(0, 1), &twist(0, 8), &twist(0, 15), &twist(0, 22)) * 1e-3;
        estimate.advance(&S, 50.0, 0.0, 0.25, &bounds);
        let before = estimate.P - bounds.P0;
        for _ in 0..100 {
            estimate.advance(&Symmetric::zeros(), 50.0, 0.3, 0.01, &bounds);
        }
        let expected = before * (-0.3_f64).exp();
        let error = (estimate.P - bounds.P0 - expected).norm() / estimate.P.norm();
        assert!(error < 100.0 * f64::EPSILON, "{error:e}");
        assert!(before.norm() > 1e-6 * estimate.P.norm());
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
            estimate.advance(&S, 5.0, 0.0, 1e-3, &bounds);
            moved |= estimate.inertia() != &nominal;
            assert!(bounds.contain(&estimate.P), "step {k}");
            assert!(estimate.inertia().m > 0.0, "step {k}");
        }
        assert!(moved);
    }

    /// With bounds as wide as the FMU allows them, P comes near singular ones, where minors are
    /// rounding errors. Eigenvalues of both matrices, scaled to a diagonal of ones, judge:
    /// nalgebra's QR iteration finds them to some ε.
    #[test]
    fn the_estimate_stays_physical_within_the_widest_bounds() {
        let mut moved = 0;
        for body in 0..20 {
            let nominal = inertia(body);
            let bounds = Bounds::around(&nominal, [1e-6, 1e6]).expect("physical");
            let mut estimate = bounds.nominal(nominal);
            for k in 0..2000 {
                let j = 2000 * body + k / 40;
                let S =
                    adaptation_direction(&twist(j, 1), &twist(j, 8), &twist(j, 15), &twist(j, 22));
                let before = estimate;
                let gamma = 10.0_f64.powf(6.0 * noise(k, 50));
                estimate.advance(&S, gamma, 0.0, 1e-3, &bounds);
                moved += usize::from(estimate != before);
                let L = PseudoInertia::from(estimate.inertia()).0;
                for (name, A) in [("P", unpacked(&estimate.P)), ("L", L)] {
                    let scaled =
                        Matrix4::from_fn(|i, j| A[(i, j)] / (A[(i, i)] * A[(j, j)]).sqrt());
                    let least = scaled.symmetric_eigenvalues().min();
                    assert!(
                        least > 0.0,
                        "body {body}, step {k}: {name} has {least:e}, {A}"
                    );
                }
            }
        }
        assert!(moved > 2000, "{moved}");
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

    /// A body that gets or loses a part keeps its estimate's difference from the nominal one in
    /// each parameter; where that would lead out of the bounds around the new nominal inertia, it
    /// starts from there. Tolerance: P is the inverse of the estimate, condition some 1e3.
    #[test]
    fn an_estimate_moves_with_its_nominal_inertia() {
        let before = inertia(3);
        let part = Inertia::from_com(6.0, Vector3::new(0.4, -0.3, 0.2), Matrix3::identity() * 0.5);
        let after = before + part;
        let bounds = Bounds::around(&before, [0.2, 5.0]).expect("physical");
        let mut estimate = bounds.nominal(before);
        let S =
            adaptation_direction(&twist(0, 1), &twist(0, 8), &twist(0, 15), &twist(0, 22)) * 1e-3;
        estimate.advance(&S, 50.0, 0.0, 0.25, &bounds);
        let difference = estimate.inertia().to_matrix() - before.to_matrix();
        let size = after.to_matrix().norm();
        assert!(difference.norm() > 1e-6 * size);

        let bounds = Bounds::around(&after, [0.2, 5.0]).expect("physical");
        let moved = estimate.moved(&before, &after, &bounds);
        let expected = after.to_matrix() + difference;
        assert!((moved.inertia().to_matrix() - expected).norm() < 1e-13 * size);
        let inverse = unpacked(&moved.P) * PseudoInertia::from(moved.inertia()).0;
        assert!((inverse - Matrix4::identity()).norm() < 1e-11, "{inverse}");
        let determinant = unpacked(&moved.P).determinant();
        assert!((moved.determinant / determinant - 1.0).abs() < 1e-11);

        let narrow = Bounds::around(&after, [1.0 - 1e-9, 1.0 + 1e-9]).expect("physical");
        assert_eq!(
            estimate.moved(&before, &after, &narrow),
            narrow.nominal(after)
        );
        // Less than nothing is no body.
        let least = Bounds::around(&(before * 1e-3), [0.2, 5.0]).expect("physical");
        let moved = estimate.moved(&(before * 2.0), &(before * 1e-3), &least);
        assert_eq!(moved, least.nominal(before * 1e-3));
    }

    /// A matrix of which a leading minor is zero is not definite.
    #[test]
    fn singular_matrices_are_not_definite() {
        for k in 0..4 {
            let mut A = Matrix4::identity();
            A[(k, k)] = 0.0;
            assert!(!Minors::new(&packed(&A)).are_positive(), "{A}");
        }
        assert!(Minors::new(&packed(&Matrix4::identity())).are_positive());
    }
}
