//! Tracking error and, in some modes, its integral: `tracking` feeds them back, `step` integrates.
//!
//! The integral is not in the paper. Without it a controller that does not compensate an unknown
//! load has a constant error, which any integral removes; with it the comparison shows what
//! adaptation adds. It shifts the reference of the inverse kinematics by z, `z' = ω e`: with the
//! feedback Λ the error follows `s² + Λ s + Λ ω = 0`, whose roots are equal at `ω = Λ/4`.

use nalgebra::Vector6;

/// Tracking errors: of the tip (position m, orientation rad), of the joints (rad), or of single
/// rods (m, first three elements).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Errors {
    /// Desired minus actual, e.
    pub(crate) e: Vector6<f64>,
    /// Integral z; zero in modes without.
    pub(crate) z: Vector6<f64>,
    /// `z' = ω e`.
    pub(crate) z_dot: Vector6<f64>,
}

impl Errors {
    /// The error `e` with its integral `z` (None: no integral) and its rate `omega`, 1/s.
    pub(crate) fn new(e: Vector6<f64>, z: Option<&Vector6<f64>>, omega: f64) -> Self {
        let [z, z_dot] = match z {
            Some(z) => [*z, e * omega],
            None => [Vector6::zeros(); 2],
        };
        Self { e, z, z_dot }
    }

    /// Advances the integral z by `h` s with the error held; frozen at a limit (anti-windup).
    pub(crate) fn advance(&self, z: &mut Vector6<f64>, is_at_limit: bool, h: f64) {
        if !is_at_limit {
            *z += self.z_dot * h;
        }
    }
}
