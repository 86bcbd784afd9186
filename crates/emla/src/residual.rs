//! Hybrid blending: the network's correction of the quasi-static force map.

use serde::{Deserialize, Serialize};

/// What the network adds to the physics at one operating point.
///
/// Source: [eq:residual_blending_hat], on the quasi-static maps. `α·dF` acts as a load on the nut,
/// `F_nut = F_spring − α·dF`, so that in steady state the delivered force is `F_qs + α·dF = F_hyb`.
/// The default, all zero, is the actuator without a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// `F_net(τ_e, w_m) − F_qs(τ_e, w_m)`, N.
    pub dF: f64,
}
