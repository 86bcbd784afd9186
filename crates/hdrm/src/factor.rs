//! Cholesky factor of the 6×6 mass matrix.

use crate::DOF;
use nalgebra::{Matrix6, Vector6};

/// `M = L Lᵀ`; the reciprocals of L's diagonal are kept.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    L: Matrix6<f64>,
    inverse_diagonal: [f64; DOF],
}

impl Factor {
    /// Reads the lower triangle. Numbers that are not finite stay so in the solution.
    pub fn new(M: &Matrix6<f64>) -> Self {
        let mut L = *M;
        let mut inverse_diagonal = [0.0; DOF];
        for j in 0..DOF {
            for k in 0..j {
                for i in j..DOF {
                    L[(i, j)] -= L[(i, k)] * L[(j, k)];
                }
            }
            let inverse = L[(j, j)].sqrt().recip();
            for i in j..DOF {
                L[(i, j)] *= inverse;
            }
            inverse_diagonal[j] = inverse;
        }
        Self {
            L,
            inverse_diagonal,
        }
    }

    /// `M⁻¹ b`.
    pub fn solve(&self, b: &Vector6<f64>) -> Vector6<f64> {
        let Self {
            L,
            inverse_diagonal,
        } = self;
        let mut x = *b;
        for j in 0..DOF {
            x[j] *= inverse_diagonal[j];
            for i in j + 1..DOF {
                x[i] -= L[(i, j)] * x[j];
            }
        }
        for j in (0..DOF).rev() {
            for i in j + 1..DOF {
                x[j] -= L[(i, j)] * x[i];
            }
            x[j] *= inverse_diagonal[j];
        }
        x
    }

    /// `(M⁻¹)_ii`: the acceleration of coordinate i per unit force on it.
    pub fn mobility(&self, i: usize) -> f64 {
        let mut unit = Vector6::zeros();
        unit[i] = 1.0;
        self.solve(&unit)[i]
    }
}
