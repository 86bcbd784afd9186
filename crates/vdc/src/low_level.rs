//! Low-level law of one actuator ([eq:voltages_Control] to [eq:current_q_required]).
//!
//! From the required force and rod motion to the dq voltages, with the controller's own nominal
//! actuator parameters. dq quantities are peak-valued.

use crate::Mode;
use emla::maps;
use machine::{Controller as Gains, Emla};

/// What the law asks of one actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RodDemand {
    /// Required force on the load, N.
    pub(crate) f_r: f64,
    /// Required rod velocity, m/s.
    pub(crate) x_r_dot: f64,
    /// Required rod acceleration, m/s².
    pub(crate) x_r_ddot: f64,
}

/// What the drive measures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Measured {
    /// Direct-axis current, A.
    pub(crate) i_d: f64,
    /// Quadrature-axis current, A.
    pub(crate) i_q: f64,
    /// Motor speed, rad/s.
    pub(crate) w_m: f64,
}

/// States of the law.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct LowLevelState {
    /// Required direct-axis current, A.
    pub(crate) i_dr: f64,
    /// Required quadrature-axis current behind the filter whose slope is d(i_qr)/dt, A.
    pub(crate) i_qr_filtered: f64,
}

/// What the law gives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Command {
    /// Direct-axis voltage, V.
    pub(crate) v_d: f64,
    /// Quadrature-axis voltage, V.
    pub(crate) v_q: f64,
    /// Required quadrature-axis current, A.
    pub(crate) i_qr: f64,
    /// `F_hyb,r − F_hyb` by [eq:Error_Force_EMLA], N.
    pub(crate) force_error: f64,
}

/// Required quadrature-axis current, A, held to the drive's limit.
///
/// Source: [eq:current_q_required] solved for `i_qr`, with the reflected inertia corrected, friction
/// at the required rates, and the required instead of the measured acceleration: the measured one
/// closes an unfiltered loop around the current and is unstable. In `pd` mode there is no model but
/// the lossless transmission.
fn required_current(p: &Emla, mode: Mode, demand: &RodDemand, now: &Measured, i_dr: f64) -> f64 {
    let travel = maps::travel_per_radian(p);
    let tau_r = match mode {
        Mode::Pd => demand.f_r * travel,
        Mode::Adaptive | Mode::Modular => maps::required_torque(
            p,
            demand.f_r,
            demand.x_r_dot / travel,
            demand.x_r_ddot / travel,
        ),
    };
    let (lambda_d, lambda_q) = (p.L_d * now.i_d + p.lambda_m, p.L_q * now.i_q);
    let i_qr = (tau_r / (1.5 * f64::from(p.p)) + lambda_q * i_dr) / lambda_d;
    i_qr.clamp(-p.i_max, p.i_max)
}

/// The voltage law.
/// ```text
/// v_d = R_s i_d + L_d di_dr/dt − p w_m λ_q + K_i (i_dr − i_d)
/// v_q = R_s i_q + L_q di_qr/dt + p w_m λ_d + K_f (F_r − F) + K_v (ẋ_r − ẋ_n)
/// ```
/// The velocity feedback acts on the motor side, `ẋ_n = lead·w_m/N`: on the rod side, as printed, it
/// is not collocated and unstable at these gains.
pub(crate) fn command(
    p: &Emla,
    gains: &Gains,
    mode: Mode,
    state: &LowLevelState,
    demand: &RodDemand,
    now: &Measured,
) -> Command {
    let Measured { i_d, i_q, w_m } = *now;
    let i_dr = state.i_dr;
    let i_qr = required_current(p, mode, demand, now, i_dr);
    let di_qr = (i_qr - state.i_qr_filtered) / gains.di_qr_filter_time;
    let force_error = maps::beta_1(p, i_d) * (i_qr - i_q) - maps::beta_2(p, i_q) * (i_dr - i_d);
    let velocity_error = demand.x_r_dot - maps::travel_per_radian(p) * w_m;
    let w_e = f64::from(p.p) * w_m;
    Command {
        v_d: p.R_s * i_d + p.L_d * i_dr_dot(gains, now) - w_e * p.L_q * i_q
            + gains.K_i * (i_dr - i_d),
        v_q: p.R_s * i_q
            + p.L_q * di_qr
            + w_e * (p.L_d * i_d + p.lambda_m)
            + gains.K_f * force_error
            + gains.K_v * velocity_error,
        i_qr,
        force_error,
    }
}

/// `di_dr/dt = −λ_i·i_d` ([eq:current_d_required] with `i_dd = 0`), A/s.
fn i_dr_dot(gains: &Gains, now: &Measured) -> f64 {
    -gains.lambda_i * now.i_d
}

impl LowLevelState {
    /// Rest at a required current: no slope at the start.
    pub(crate) fn settled(i_qr: f64) -> Self {
        Self {
            i_dr: 0.0,
            i_qr_filtered: i_qr,
        }
    }

    /// Advances by `h` s with the measured and required currents held; the filter is exact for that.
    pub(crate) fn advance(&mut self, gains: &Gains, now: &Measured, i_qr: f64, h: f64) {
        self.i_dr += h * i_dr_dot(gains, now);
        let reached = -(-h / gains.di_qr_filter_time).exp_m1();
        self.i_qr_filtered += reached * (i_qr - self.i_qr_filtered);
    }
}
