//! Control law, a mode for comparison: computed torque with a disturbance observer at the joints.
//!
//! Source: W.-H. Chen, D. J. Ballance, P. J. Gawthrop, J. O'Reilly, *A nonlinear disturbance
//! observer for robotic manipulators*, IEEE Transactions on Industrial Electronics 47(4), 2000.
//!
//! With the required rates as reference, `s = ζ̇_r − ζ̇`, and the computed torque, the error obeys
//! `M ṡ = d − κ M s − d̂`. The observer `d̂' = ω (d − d̂) = ω (M ṡ + κ M s)` has the solution
//! ```text
//! d̂ = ω M s + ω κ ∫ M s dt
//! ```
//! which needs no acceleration. Its bandwidth ω is `omega_tip`, the rate at which the other laws
//! integrate the tip's error.

use crate::law::control_law::{ControlLaw, Forces, Instant};

pub(crate) struct DisturbanceObserver;

impl ControlLaw for DisturbanceObserver {
    fn forces(&self, now: &Instant) -> Forces {
        let (kappa, omega) = (now.gains.kappa_KA, now.gains.omega_tip);
        let (model, momentum) = (now.model(), now.momentum());
        let torque = |i: usize| model[i] + (kappa + omega) * momentum[i] + now.law_integral[i];
        Forces {
            law_integral_rate: momentum.map(|p| omega * kappa * p),
            ..now.forces_from_joints(std::array::from_fn(torque))
        }
    }
}
