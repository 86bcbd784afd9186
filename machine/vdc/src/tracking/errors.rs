//! The tracking error and its integral, in the modes that have one.
//!
//! The integral is not in the paper. Without it a controller that compensates no unknown load
//! stands beside its reference by a constant sag, which any integral removes; with it the
//! comparison shows what else adaptation brings. It shifts the reference of the inverse kinematics
//! by z, `z' = ω e`: with the feedback Λ the error follows `s² + Λ s + Λ ω = 0`, whose roots are
//! equal at `ω = Λ/4`.

use nalgebra::Vector6;

/// Errors that the feedback acts on: of the tip, position m and orientation rad, or of the joints,
/// rad; of single rods, m, in the first three places.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Errors {
    /// Desired minus actual, e.
    pub(crate) e: Vector6<f64>,
    /// Integral part z; zero in the modes without.
    pub(crate) z: Vector6<f64>,
    /// `z' = ω e`.
    pub(crate) z_dot: Vector6<f64>,
}

impl Errors {
    /// The error `e` with its integral part `z`, which grows at the rate `omega`, 1/s; None in the
    /// modes without.
    pub(crate) fn new(e: Vector6<f64>, z: Option<&Vector6<f64>>, omega: f64) -> Self {
        let [z, z_dot] = match z {
            Some(z) => [*z, e * omega],
            None => [Vector6::zeros(); 2],
        };
        Self { e, z, z_dot }
    }

    /// Advances the integral z by `h` s with the error held. While a drive or a wrist joint is at
    /// its limit z rests, or it would wind up.
    pub(crate) fn advance(&self, z: &mut Vector6<f64>, is_at_limit: bool, h: f64) {
        if !is_at_limit {
            *z += self.z_dot * h;
        }
    }
}
