//! Factor of the 6×6 mass matrix, for accelerations and for effective masses at stops and contacts.

use crate::DOF;
use nalgebra::{Matrix6, Vector6};

/// `M = L·D·Lᵀ`, L unit lower triangular, D diagonal: Cholesky without the slow square roots.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    L: Matrix6<f64>,
    /// `D⁻¹`.
    reciprocals: [f64; DOF],
}

impl Factor {
    /// Reads the lower triangle. Values that are not finite propagate to the solution.
    pub fn new(M: &Matrix6<f64>) -> Self {
        let (mut L, mut reciprocals) = (*M, [0.0; DOF]);
        for j in 0..DOF {
            let reciprocal = L[(j, j)].recip();
            for k in j + 1..DOF {
                let L_kj = L[(k, j)] * reciprocal;
                for i in k..DOF {
                    L[(i, k)] -= L[(i, j)] * L_kj;
                }
                L[(k, j)] = L_kj;
            }
            reciprocals[j] = reciprocal;
        }
        Self { L, reciprocals }
    }

    pub fn solve(&self, b: &Vector6<f64>) -> Vector6<f64> {
        let Self { L, reciprocals } = self;
        let mut x = *b;
        for j in 0..DOF {
            for i in j + 1..DOF {
                x[i] -= L[(i, j)] * x[j];
            }
        }
        for j in (0..DOF).rev() {
            x[j] *= reciprocals[j];
            for i in j + 1..DOF {
                x[j] -= L[(i, j)] * x[i];
            }
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
