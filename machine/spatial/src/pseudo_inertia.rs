//! Pseudo-inertia: the inertial parameters of a body as a symmetric 4×4 matrix, the form in which
//! the controller adapts its estimates and the identification study varies bodies.

use crate::Inertia;
use nalgebra::{Matrix3, Matrix4};
use serde::{Deserialize, Serialize};

/// `f(θ_A) = L_A = [½tr(I)·1 − I, h; hᵀ, m]` (the paper's natural adaptation law). The body is
/// physically consistent (a positive mass distribution exists) exactly when `L` is positive
/// definite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PseudoInertia(pub Matrix4<f64>);

impl From<&Inertia> for PseudoInertia {
    fn from(body: &Inertia) -> Self {
        let Inertia { m, h, I } = body;
        let Sigma = Matrix3::from_diagonal_element(0.5 * I.trace()) - I;
        let mut L = Matrix4::zeros();
        L.fixed_view_mut::<3, 3>(0, 0).copy_from(&Sigma);
        L.fixed_view_mut::<3, 1>(0, 3).copy_from(h);
        L.fixed_view_mut::<1, 3>(3, 0).copy_from(&h.transpose());
        L[(3, 3)] = *m;
        Self(L)
    }
}

/// `f⁻¹(L) = (m, h, tr(Σ)·1 − Σ)`, Σ the upper left 3×3 block.
impl From<&PseudoInertia> for Inertia {
    fn from(L: &PseudoInertia) -> Self {
        let Sigma: Matrix3<f64> = L.0.fixed_view::<3, 3>(0, 0).into();
        Self {
            m: L.0[(3, 3)],
            h: L.0.fixed_view::<3, 1>(0, 3).into(),
            I: Matrix3::from_diagonal_element(Sigma.trace()) - Sigma,
        }
    }
}
