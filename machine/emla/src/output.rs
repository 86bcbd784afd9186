//! All outputs of the actuator at one instant, for the FMU, the controller and the studies.

use crate::actuator::Emla;
use crate::dynamics::{power_in, power_out};
use crate::efficiency::{Efficiency, Powers, is_defined};
use crate::maps;
use crate::state::State;
use machine_file::{ActuatorInput as Input, link_current};
use serde::{Deserialize, Serialize};

/// Outputs for a state and the present inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// Force on the load, N, positive when the actuator pushes; see [`Emla::with_delay`].
    pub F: f64,
    /// Mean of `F` over the last step, N.
    pub F_mean: f64,
    /// Quasi-static force of the physics at this torque and speed, N.
    pub F_phys: f64,
    /// Quasi-static force of the hybrid model, `F_phys + α·dF`, N.
    pub F_hyb: f64,
    /// Force of the network at this torque and speed, N; 0 without one.
    pub F_net: f64,
    /// Rod position, m.
    pub x_rod: f64,
    /// Rod velocity, m/s.
    pub x_rod_dot: f64,
    /// Position of the free rod, m; in [`crate::Drive::Motion`] the start value.
    pub x_free: f64,
    /// Velocity of the free rod, m/s; in [`crate::Drive::Motion`] the start value.
    pub x_free_dot: f64,
    /// Rod velocity of the network, m/s; 0 without one.
    pub x_dot_net: f64,
    /// Quasi-static rod velocity of the hybrid model, `x_dot + α·(x_dot_net − x_dot)`, m/s.
    pub x_dot_hyb: f64,
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
    /// Mean of `P_in` over the last step, W.
    pub P_in_mean: f64,
    /// Current from the DC side, A: `v_dc·i_dc = P_in`; 0 from a link below 1 V.
    pub i_dc: f64,
    /// Mean of `i_dc` over the last step, A.
    pub i_dc_mean: f64,
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
    /// Work on the load since the start by shifts of the rod between steps, J:
    /// `E_in = E_out + E_shift + E_loss + ΔE_stored`.
    pub E_shift: f64,
    /// Energy lost since the start, J.
    pub E_loss: f64,
    /// Energy stored in field, rotating parts, spring and free rod, J.
    pub E_stored: f64,
    /// Heat flow to the air, W; 0 if heat is not modelled.
    pub P_heat: f64,
    /// Part of `E_loss` in the inverter, which has its own cooling, J; 0 without heat.
    pub E_inverter: f64,
    /// Heat given to the air since the start, J.
    pub E_heat: f64,
    /// Heat stored in winding and housing above the reference temperature, J.
    pub E_thermal: f64,
    /// Temperature of the winding, K.
    pub T_winding: f64,
    /// Temperature of the housing, K.
    pub T_housing: f64,
    /// Whether undervoltage has tripped the drive.
    pub tripped: bool,
    /// Efficiency of the hybrid model, `η + α·(η_net − η)`; 0 where it is not defined.
    pub efficiency: f64,
    /// Efficiency of the physics; 0 where it is not defined.
    pub efficiency_phys: f64,
    /// Efficiency of the network; 0 where it is not defined, and without a network.
    pub efficiency_net: f64,
    /// Whether the efficiency is defined: τ_e > 0 and w_m ≠ 0 (quadrants I and IV).
    pub efficiency_valid: bool,
    /// Whether torque and speed are in the network's trained range.
    pub in_trained_range: bool,
    /// Interval of the efficiency around the network's; [0, 1] without [`Emla::with_interval`] and
    /// where the efficiency is not defined.
    pub efficiency_interval: [f64; 2],
}

impl Emla {
    /// Outputs of state `s` under the inputs `u`.
    #[must_use]
    pub fn output(&self, s: &State, u: &Input) -> Output {
        let p = self.at_temperature(&s.thermal);
        let held = self.conditions(&p, s, u);
        let now = self.instant(&s.point(), u, &held);
        let losses = self.losses(&now, &held);
        let F_phys = maps::quasi_static_force(&self.p, now.tau_e, now.w_m);
        let (P_in, P_out) = (power_in(&now, &losses), power_out(self.drive, &now, u));
        let valid = is_defined(now.tau_e, now.w_m);
        let efficiency = |out: f64| {
            let powers = Powers {
                shaft: now.tau_e * now.w_m,
                electrical: losses.electrical(),
                out,
            };
            Efficiency::new(powers, now.tau_e, now.w_m).map_or(0.0, Efficiency::value)
        };
        let net = &s.residual;
        let efficiency_phys = efficiency(F_phys * now.x_n_dot);
        let efficiency_net = efficiency(net.F_net * net.x_dot_net);
        Output {
            F: now.F + s.lead * now.K_b * now.stretch_dot,
            F_mean: s.F_mean,
            F_phys,
            F_hyb: F_phys + self.alpha * net.dF,
            F_net: net.F_net,
            x_rod: now.x,
            x_rod_dot: now.x_dot,
            x_free: s.x,
            x_free_dot: s.x_dot,
            x_dot_net: net.x_dot_net,
            x_dot_hyb: self.blend(now.x_n_dot, net.x_dot_net),
            i_d: s.i_d,
            i_q: s.i_q,
            theta_m: s.theta_m,
            w_m: s.w_m,
            tau_e: now.tau_e,
            P_in,
            P_in_mean: s.P_in_mean,
            i_dc: link_current(P_in, held.v_dc),
            i_dc_mean: s.i_dc_mean,
            P_out,
            P_loss: losses.total(),
            P_copper: losses.copper,
            P_core: losses.core,
            P_inverter: losses.inverter,
            P_mech: losses.mechanical(),
            E_in: s.energy.supplied,
            E_out: s.energy.delivered,
            E_shift: s.shift,
            E_loss: s.energy.lost,
            E_stored: self.stored(&now),
            P_heat: self.heat_flow(&s.thermal, u.T_ambient),
            E_inverter: s.kinds.inverter,
            E_heat: s.thermal.given,
            E_thermal: self.heat_held(&s.thermal),
            T_winding: s.thermal.T_winding,
            T_housing: s.thermal.T_housing,
            tripped: s.tripped,
            efficiency: self.blend(efficiency_phys, efficiency_net),
            efficiency_phys,
            efficiency_net,
            efficiency_valid: valid,
            in_trained_range: net.in_trained_range,
            efficiency_interval: match (&self.bound, &self.surrogate) {
                (Some(bound), Some(network)) if valid => {
                    let cut = self.force_held_back(network, now.tau_e, now.w_m) * now.x_n_dot;
                    let half = bound.half_width((net.F_net * net.x_dot_net).abs(), cut.abs());
                    [-half, half].map(|side| (efficiency_net + side).clamp(0.0, 1.0))
                }
                _ => [0.0, 1.0],
            },
        }
    }

    /// `physics + α·(network − physics)`, Eq. (eq:residual_blending_hat); α = 0 without one.
    pub(crate) fn blend(&self, physics: f64, network: f64) -> f64 {
        match self.surrogate {
            Some(_) => physics + self.alpha * (network - physics),
            None => physics,
        }
    }
}
