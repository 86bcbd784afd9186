//! Static maps of the actuator, functions of parameters and operating point alone: transmission,
//! gear loss, stiffness, torque, quasi-static force and its inverse. This model, the controller,
//! `motion-check` and the studies call them, each with its own parameters.
//!
//! Quotients of parameters come first in a product (`1/N·τ`, not `τ/N`): the compiler then moves
//! them out of the loop over the substeps, where a division costs as much as ten sums.

use crate::motor;
use crate::tanh::tanh;
use machine_file::{Dq, Emla};

/// Nut travel per radian of the screw, `ρ/2π`, m/rad. Source: `[paper]` Eq. (eq:linear_velocity).
pub fn lead(p: &Emla) -> f64 {
    p.rho / std::f64::consts::TAU
}

/// Nut travel per radian of the motor, `ρ/(2πN)`, m/rad. Source: `[paper]` Eq. (eq:gear_velocity).
pub fn travel_per_radian(p: &Emla) -> f64 {
    lead(p) / p.N_gear
}

/// Electromagnetic torque, N·m. Source: `[paper]` Eq. (eq:PMSM_torque).
/// ```text
/// τ_e = 3/2·p·(λ_d i_q − λ_q i_d)
/// ```
pub fn torque(p: &Emla, i_d: f64, i_q: f64) -> f64 {
    let lambda = motor::flux(p, Dq { d: i_d, q: i_q });
    1.5 * f64::from(p.p) * (lambda.d * i_q - lambda.q * i_d)
}

/// Energy of the currents' field, J: `3/4·(L_d i_d² + L_q i_q²)`.
pub fn magnetic_energy(p: &Emla, i_d: f64, i_q: f64) -> f64 {
    0.75 * (p.L_d * i_d * i_d + p.L_q * i_q * i_q)
}

/// Axial stiffness between nut and rod at rod position `x`, N/m.
///
/// Source: `[paper]` Eqs. (eq:ballscrew_stiffness), (eq:shaft_effective_length). A series
/// stiffness: the paper's text calls it parallel, its formula is in series; its K_s is the axial
/// rigidity EA in N, its K_rot the torsional rigidity GJ in N·m².
/// ```text
/// ℓ_s = x (L_s − x)/L_s
/// 1/K_b = ℓ_s/EA + 1/(2 K_br) + 1/K_n + 1/K_r + ρ² x/(4π² GJ)
/// ```
/// Outside the screw, x ∉ [0, L_s], the value at the nearer end holds.
pub fn stiffness(p: &Emla, x: f64) -> f64 {
    stiffness_and_slope(p, x).0
}

/// [`stiffness`] and its derivative with respect to x, N/m²: `K_b' = −K_b²·(1/K_b)'`.
#[inline(always)]
pub fn stiffness_and_slope(p: &Emla, x: f64) -> (f64, f64) {
    // Not `clamp`, which panics if L_s is negative, as it may be in a damaged saved state.
    let inside = x.max(0.0).min(p.L_s);
    let l_s = inside - 1.0 / p.L_s * (inside * inside);
    let fixed = 1.0 / (2.0 * p.K_br) + 1.0 / p.K_n + 1.0 / p.K_r;
    let twist = lead(p) * lead(p) / p.GJ;
    let K_b = 1.0 / (1.0 / p.EA * l_s + fixed + twist * inside);
    (K_b, -K_b * K_b * compliance_slope(p, x))
}

/// Derivative of the compliance `1/K_b` with respect to x, 1/N.
fn compliance_slope(p: &Emla, x: f64) -> f64 {
    if !(0.0..=p.L_s).contains(&x) {
        return 0.0;
    }
    1.0 / p.EA * (1.0 - 2.0 / p.L_s * x) + lead(p) * lead(p) / p.GJ
}

/// Second derivative of [`stiffness`], N/m³: `K_b'' = 2 K_b³ (1/K_b)'² − K_b² (1/K_b)''`.
pub(crate) fn stiffness_curvature(p: &Emla, x: f64) -> f64 {
    if !(0.0..=p.L_s).contains(&x) {
        return 0.0;
    }
    let (K_b, slope) = (stiffness(p, x), compliance_slope(p, x));
    K_b * K_b * (2.0 * K_b * slope * slope + 2.0 / (p.L_s * p.EA))
}

/// Ratio of gear input torque to the lossless one, for a screw-side torque `tau_load` (only its
/// sign counts, positive against positive rotation) at motor speed `w_m`.
///
/// ```text
/// k = (1/η + η)/2 + (1/η − η)/2·sign(τ_load)·tanh(w_m/w_η)
/// ```
/// 1/η when the motor drives the load, η when the load drives the motor. Departs from
/// Eq. (eq:gear_torque), whose single η would make a back-driven gear create energy. At rest
/// k = (1/η + η)/2 > 1, so below |w_m| = w_η·artanh((1−η)/(1+η)) a back-driven gear still gains
/// `(k − 1)` of the load's power: at most (m−1)²/(4d)·w_η·|τ_load|/N with m = (1/η + η)/2 and
/// d = (1/η − η)/2, 0.25 mW for the reference actuator at 70 kN.
pub fn gear_factor(p: &Emla, tau_load: f64, w_m: f64) -> f64 {
    let (mean, half) = gear_factor_parts(p);
    mean + half * sign(tau_load) * tanh(1.0 / p.w_eta * w_m)
}

/// Derivative of [`gear_factor`] with respect to `w_m`, s/rad.
pub(crate) fn gear_factor_slope(p: &Emla, tau_load: f64, w_m: f64) -> f64 {
    gear_factor_parts(p).1 * sign(tau_load) * sech2(w_m / p.w_eta) / p.w_eta
}

fn gear_factor_parts(p: &Emla) -> (f64, f64) {
    let eta = p.eta_gear;
    (0.5 * (1.0 / eta + eta), 0.5 * (1.0 / eta - eta))
}

/// Sign with sign(0) = 0 (`f64::signum` gives 1 there).
pub(crate) fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// Derivative of tanh.
pub(crate) fn sech2(z: f64) -> f64 {
    let t = tanh(z);
    1.0 - t * t
}

/// Friction of the motor, N·m: `C_m w_m + τ_C tanh(w_m/w_C)`. Source: `[paper]` Eq.
/// (eq:rotor_dynamics), with the Coulomb friction opposing the motion and zero at rest.
pub fn motor_friction(p: &Emla, w_m: f64) -> f64 {
    p.C_m * w_m + p.tau_C * tanh(1.0 / p.w_C * w_m)
}

/// Derivative of [`motor_friction`] with respect to `w_m`, N·m·s/rad.
pub(crate) fn motor_friction_slope(p: &Emla, w_m: f64) -> f64 {
    p.C_m + p.tau_C / p.w_C * sech2(w_m / p.w_C)
}

/// Torque on the screw by its friction and by the nut, N·m: `C_s w_m/N + lead·F_nut`.
pub fn screw_load(p: &Emla, F_nut: f64, w_m: f64) -> f64 {
    p.C_s / p.N_gear * w_m + lead(p) * F_nut
}

/// Inertia that the motor accelerates, kg·m²: `J_m + k J_s/N²`, the single inertia of the rigid
/// gear, which the paper's rotor, gear and screw equations over-determine. It replaces the
/// dimensionally wrong `J_m + M_act/(N + η_f)` of Eq. (eq:current_q_required).
pub fn inertia(p: &Emla, k: f64) -> f64 {
    p.J_m + p.J_s / (p.N_gear * p.N_gear) * k
}

/// Motor torque that delivers the force `F` at motor speed `w_m` and acceleration `w_m_dot`, N·m,
/// with the rod following the nut: nut force `F + C_act·x_dot`.
/// ```text
/// τ_e = (J_m + k J_s/N²) ẇ_m + C_m w_m + τ_C tanh(w_m/w_C) + k (C_s w_m/N + lead·F_nut)/N
/// ```
/// The rod's mass is not included; it belongs to the mechanism that the rod is coupled to.
pub fn required_torque(p: &Emla, F: f64, w_m: f64, w_m_dot: f64) -> f64 {
    let F_nut = F + p.C_act * travel_per_radian(p) * w_m;
    let tau_load = screw_load(p, F_nut, w_m);
    let k = gear_factor(p, tau_load, w_m);
    inertia(p, k) * w_m_dot + motor_friction(p, w_m) + k * tau_load / p.N_gear
}

/// Quasi-static force on the load at torque `tau_e` and constant motor speed `w_m`, N:
/// `F_ext(θ̇_m, τ_e)` of Eq. (eq:residual_blending_hat), the inverse of [`required_torque`] at
/// `ẇ_m = 0`. As k > 0, the load has the sign of the torque minus the motor's friction.
pub fn quasi_static_force(p: &Emla, tau_e: f64, w_m: f64) -> f64 {
    let tau = tau_e - motor_friction(p, w_m);
    let tau_load = p.N_gear * tau / gear_factor(p, tau, w_m);
    let F_nut = (tau_load - p.C_s * w_m / p.N_gear) / lead(p);
    F_nut - p.C_act * travel_per_radian(p) * w_m
}

/// Partial derivatives of [`quasi_static_force`] by `tau_e` (1/m) and by `w_m` (N·s/rad).
pub(crate) fn quasi_static_slopes(p: &Emla, tau_e: f64, w_m: f64) -> (f64, f64) {
    let tau = tau_e - motor_friction(p, w_m);
    let k = gear_factor(p, tau, w_m);
    let by_tau = p.N_gear / (k * lead(p));
    let by_k = -by_tau * tau / k;
    let by_w = -by_tau * motor_friction_slope(p, w_m) + by_k * gear_factor_slope(p, tau, w_m)
        - p.C_s / (p.N_gear * lead(p))
        - p.C_act * travel_per_radian(p);
    (by_tau, by_w)
}

/// β₁ of Eq. (eq:Error_Force_EMLA) at α = 0, N/A: lossless force per quadrature current,
/// `(2πN/ρ)·(3/2)·p·λ_d` (the paper's second line repeats the factor 3/2·p).
pub fn beta_1(p: &Emla, i_d: f64) -> f64 {
    1.5 * f64::from(p.p) * (p.L_d * i_d + p.lambda_m) / travel_per_radian(p)
}

/// β₂ of Eq. (eq:Error_Force_EMLA) at α = 0, N/A: `(2πN/ρ)·(3/2)·p·λ_q`.
pub fn beta_2(p: &Emla, i_q: f64) -> f64 {
    1.5 * f64::from(p.p) * p.L_q * i_q / travel_per_radian(p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::Machine;

    /// Central differences, also where gear and friction turn over: their error is the third
    /// derivative's share, (δ/w_η)² of the slope, and rounding, ε/δ of the force.
    #[test]
    fn slopes_of_the_quasi_static_force_match_differences() {
        let p = Machine::reference().emla.lift;
        for tau in [-7.0, 3.0, 11.0] {
            for w in [-3.0, -0.4, 0.0, 0.3, 1.7, 60.0].map(|w| w * p.w_eta) {
                let (by_tau, by_w) = quasi_static_slopes(&p, tau, w);
                let force = |tau: f64, w: f64| quasi_static_force(&p, tau, w);
                let [d_tau, d_w] = [1e-4, 1e-4 * p.w_eta];
                let found_tau = (force(tau + d_tau, w) - force(tau - d_tau, w)) / (2.0 * d_tau);
                let found_w = (force(tau, w + d_w) - force(tau, w - d_w)) / (2.0 * d_w);
                assert!(
                    (by_tau / found_tau - 1.0).abs() < 1e-7,
                    "{tau} {w}: {by_tau} {found_tau}"
                );
                assert!(
                    (by_w / found_w - 1.0).abs() < 1e-6,
                    "{tau} {w}: {by_w} {found_w}"
                );
            }
        }
    }

    /// Force of the screw without losses: 2π N/ρ times the torque (3/2) p λ per ampere.
    #[test]
    fn betas_are_the_lossless_force_per_ampere() {
        let p = Machine::reference().emla.lift;
        let (turns, torque) = (
            std::f64::consts::TAU * p.N_gear / p.rho,
            1.5 * f64::from(p.p),
        );
        for i in [-7.0, 0.0, 13.0] {
            let expected =
                [p.lambda_m + p.L_d * i, p.L_q * i].map(|lambda| turns * torque * lambda);
            for (found, expected) in [beta_1(&p, i), beta_2(&p, i)].into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= 1e-13 * expected.abs(),
                    "{found} {expected}"
                );
            }
        }
    }
}
