//! All outputs of the actuator at one instant, for the FMU `Rig` and the studies.

use crate::{Input, Rig, State};
use serde::{Deserialize, Serialize};

/// Outputs for a state and the present inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// Force on the load, N, positive when the actuator pushes; predicted with a `delay`.
    pub F: f64,
    /// Mean of `F` over the last step, N.
    pub F_mean: f64,
    /// Rod position, m.
    pub x_rod: f64,
    /// Rod velocity, m/s.
    pub x_rod_dot: f64,
    /// Nut position, m.
    pub x_nut: f64,
    /// Direct-axis current as the drive measures it, A.
    pub i_d: f64,
    /// Quadrature-axis current as the drive measures it, A.
    pub i_q: f64,
    /// Motor angle, rad.
    pub theta_m: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Electromagnetic torque, N·m.
    pub tau_e: f64,
    /// Direct-axis voltage at the motor, V.
    pub v_d_motor: f64,
    /// Quadrature-axis voltage at the motor, V.
    pub v_q_motor: f64,
    /// Deflection of the friction's bristles, m.
    pub presliding: f64,
    /// Power from the DC side, W.
    pub P_in: f64,
    /// Its mean over the last step, W.
    pub P_in_mean: f64,
    /// Current from the DC side, A: `v_dc·i_dc = P_in`; 0 from a link below 1 V.
    pub i_dc: f64,
    /// Mean of `i_dc` over the last step, A.
    pub i_dc_mean: f64,
    /// Power to the load, W.
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
    /// Heat flow to the air, W.
    pub P_heat: f64,
    /// Energy taken from the DC side since the start, J.
    pub E_in: f64,
    /// Energy given to the load since the start, J.
    pub E_out: f64,
    /// Work on the load since the start by shifts of the rod between steps, J:
    /// `E_in = E_out + E_shift + E_loss + ΔE_stored`.
    pub E_shift: f64,
    /// Energy lost since the start, J.
    pub E_loss: f64,
    /// Part of `E_loss` in the inverter, J.
    pub E_inverter: f64,
    /// Energy in field, rotating parts, springs, bristles and free rod, J.
    pub E_stored: f64,
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
    /// Efficiency over the last step; 0 where it is not defined.
    pub efficiency: f64,
    /// Whether the efficiency is defined: τ_e > 0 and w_m ≠ 0 (quadrants I and IV).
    pub efficiency_valid: bool,
}

impl Rig {
    /// Outputs of state `s` under the inputs `u`.
    pub fn output(&self, s: &State, u: &Input) -> Output {
        let now = self.instant(s, u, &self.conditions(s, u));
        let P_in = now.supplied(s.current());
        let measured = self.measured_currents(s.current());
        let is_defined = now.magnetics.tau_e > 0.0 && s.w_m != 0.0;
        Output {
            F: now.F + s.lead * now.link.stiffness * now.s_dot,
            F_mean: s.F_mean,
            x_rod: now.x,
            x_rod_dot: now.x_dot,
            x_nut: self.travel() * s.theta_m,
            i_d: measured.d,
            i_q: measured.q,
            theta_m: s.theta_m,
            w_m: s.w_m,
            tau_e: now.magnetics.tau_e,
            v_d_motor: now.v.d,
            v_q_motor: now.v.q,
            presliding: s.z,
            P_in,
            P_in_mean: s.mean.supplied,
            i_dc: machine_file::link_current(P_in, self.link_voltage(u)),
            i_dc_mean: s.i_dc_mean,
            P_out: now.delivered,
            P_loss: now.lost(),
            P_copper: now.copper,
            P_core: now.core,
            P_inverter: now.inverter,
            P_mech: now.mechanical,
            P_heat: now.warming.given,
            E_in: s.energy.supplied,
            E_out: s.energy.delivered,
            E_shift: s.shift,
            E_loss: s.energy.lost,
            E_inverter: s.energy.inverter,
            E_stored: self.stored(s, &now),
            E_heat: s.energy.heat,
            E_thermal: self.heat_held(s.T),
            T_winding: s.T[0],
            T_housing: s.T[1],
            tripped: s.tripped,
            efficiency: if is_defined {
                efficiency(s.mean.delivered, s.mean.lost, s.w_m)
            } else {
                0.0
            },
            efficiency_valid: is_defined,
        }
    }
}

/// Efficiency from the mean powers `delivered` to the load and `lost`, W, at the motor speed `w_m`.
/// Computed from the losses, so that changes of the stored energy do not affect it; limited to
/// [0, 1].
/// ```text
/// quadrant I:   η = P_out/(P_out + P_loss)
/// quadrant IV:  η = (|P_out| − P_loss)/|P_out|
/// ```
pub fn efficiency(delivered: f64, lost: f64, w_m: f64) -> f64 {
    let out = delivered * w_m.signum();
    let (gained, spent) = if w_m > 0.0 {
        (out, out + lost)
    } else {
        (out - lost, out)
    };
    if gained <= 0.0 || spent <= 0.0 {
        return 0.0;
    }
    (gained / spent).min(1.0)
}
