//! Control law, a mode for comparison: second-order sliding mode (super-twisting).
//!
//! Source: J. A. Moreno, M. Osorio, *Strict Lyapunov functions for the super-twisting algorithm*,
//! IEEE TAC 57(4), 2012. With `s = ζ̇_r − ζ̇` as the sliding variable, scaled by the inertia:
//! ```text
//! τ = model + κ M s·√(s_0/|s|) + v,   v' = ω κ M s·s_0/|s|
//! ```
//! which for one joint is `κ M √(s_0|s|) sign s` and `ω κ M s_0 sign s`. `κ` is `kappa_KA` and ω is
//! `omega_tip`. Within the boundary layer `|s| < s_1` both are linear, because a law sampled at 1
//! ms cannot switch arbitrarily fast.

use crate::law::control_law::{ControlLaw, Forces, Instant};

/// Rate error at which the gain equals that of the linear law, rad/s: a tenth of usual joint rates.
const S_0: f64 = 1e-2;
/// Boundary layer, rad/s: within it the gain is four times that of the linear law.
const S_1: f64 = S_0 / 16.0;

pub(crate) struct SuperTwisting;

impl ControlLaw for SuperTwisting {
    fn forces(&self, now: &Instant) -> Forces {
        let (kappa, omega) = (now.gains.kappa_KA, now.gains.omega_tip);
        let (model, momentum) = (now.model(), now.momentum());
        let share = |i: usize| S_0 / now.rate_error(i).abs().max(S_1);
        let torque =
            |i: usize| model[i] + kappa * momentum[i] * share(i).sqrt() + now.law_integral[i];
        Forces {
            law_integral_rate: std::array::from_fn(|i| omega * kappa * momentum[i] * share(i)),
            ..now.forces_from_joints(std::array::from_fn(torque))
        }
    }
}
