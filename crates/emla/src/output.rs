//! What the actuator shows at one instant.

use crate::Emla;
use crate::dynamics::{State, power_in};
use crate::input::Input;
use crate::losses::{Losses, efficiency, efficiency_ratio};
use crate::maps;
use serde::{Deserialize, Serialize};

/// Outputs, of the state and the current inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// Force on the load, N, positive when the actuator pushes.
    pub F: f64,
    /// Mean of `F` over the last step, N.
    pub F_mean: f64,
    /// Quasi-static force of the physics at this torque and speed, N.
    pub F_phys: f64,
    /// Quasi-static force of the hybrid model, `F_phys + α·dF`, N.
    pub F_hyb: f64,
    /// Rod position, m.
    pub x_rod: f64,
    /// Rod velocity, m/s.
    pub x_rod_dot: f64,
    /// Direct-axis current, A (peak).
    pub i_d: f64,
    /// Quadrature-axis current, A (peak).
    pub i_q: f64,
    /// Motor angle, rad.
    pub theta_m: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Electromagnetic torque, N·m.
    pub tau_e: f64,
    /// Electrical power from the DC side, W.
    pub P_in: f64,
    /// Mechanical power to the load, W.
    pub P_out: f64,
    /// All losses, W.
    pub P_loss: f64,
    /// Copper losses, W.
    pub P_copper: f64,
    /// Iron losses, W.
    pub P_core: f64,
    /// Inverter losses, W.
    pub P_inverter: f64,
    /// Mechanical losses, W.
    pub P_mech: f64,
    /// Energy taken from the DC side since the start, J.
    pub E_in: f64,
    /// Energy given to the load since the start, J.
    pub E_out: f64,
    /// Energy lost since the start, J.
    pub E_loss: f64,
    /// Energy stored in field, rotating parts, spring and free rod, J.
    pub E_stored: f64,
    /// Efficiency; 0 where it is not defined.
    pub efficiency: f64,
    /// Whether the efficiency is defined: τ_e > 0 and w_m ≠ 0 (quadrants I and IV).
    pub efficiency_valid: bool,
}

impl Emla {
    /// Outputs of state `s` under the inputs `u`.
    #[must_use]
    pub fn output(&self, s: &State, u: &Input) -> Output {
        let now = self.instant(s, u);
        let losses = self.losses(s, &now);
        let F_phys = maps::quasi_static_force(&self.p, now.tau_e, now.w_m);
        let P_out = self.power_out(&now, u);
        let ratio = efficiency_ratio(now.tau_e, now.w_m, P_out, losses.electrical());
        Output {
            F: now.F,
            F_mean: s.F_mean,
            F_phys,
            F_hyb: F_phys + self.alpha * s.residual.dF,
            x_rod: now.x,
            x_rod_dot: now.x_dot,
            i_d: s.i_d,
            i_q: s.i_q,
            theta_m: s.theta_m,
            w_m: s.w_m,
            tau_e: now.tau_e,
            P_in: power_in(&now, &losses),
            P_out,
            P_loss: losses.total(),
            P_copper: losses.copper,
            P_core: losses.core,
            P_inverter: losses.inverter,
            P_mech: losses.mechanical(),
            E_in: s.energy.supplied,
            E_out: s.energy.delivered,
            E_loss: s.energy.lost,
            E_stored: self.stored(&now),
            efficiency: ratio.map_or(0.0, efficiency),
            efficiency_valid: ratio.is_some(),
        }
    }

    /// Losses by kind in state `s` under the inputs `u`.
    #[must_use]
    pub fn losses_at(&self, s: &State, u: &Input) -> Losses {
        self.losses(s, &self.instant(s, u))
    }
}
