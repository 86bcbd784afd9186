//! Longest substep, by the fastest mode and an error bound of the force; `Emla::new` computes it.

use crate::maps;
use machine_file::Drive;
use model_rules::RATE_STEP;

/// Largest integration error of the force, N, while the load keeps its sign; see
/// [`dt_for_force_error`].
const FORCE_ERROR: f64 = 0.05;
/// Time in which the voltage changes by `v_max`, s, for which [`FORCE_ERROR`] holds: some 20 times
/// as fast as the reference motions ask for.
const VOLTAGE_SWEEP: f64 = 0.1;
/// Longest substep with a free rod, s.
const DT_MAX_FORCE: f64 = 0.125e-3;

/// Rate of the faster mode of a mass `m` on spring `k` and damper `c`, 1/s.
fn fast_rate(m: f64, c: f64, k: f64) -> f64 {
    let (half, w2) = (0.5 * c / m, k / m);
    let discriminant = half * half - w2;
    if discriminant > 0.0 {
        half + discriminant.sqrt()
    } else {
        w2.sqrt()
    }
}

/// Substep, s, for which RK4's error of the force is [`FORCE_ERROR`], when the rod's motion is
/// prescribed and the voltage changes at the rate `v̇ = v_max/VOLTAGE_SWEEP`.
///
/// RK4's error of `e^z` is `z⁵/120`. For a linear system `y' = A·y + B·v` whose voltage is held
/// over each communication step but grows at the mean rate `v̇`, the errors of all substeps add up
/// to `A²·B·v̇·dt⁴/120` in the steady state, whatever the communication step. For the force the
/// leading term is
/// ```text
/// δF = ω₀²·(β₁/L)·v̇·dt⁴/120,   ω₀² = K_b·(ρ/(2πN))²/J
/// ```
/// `β₁/L·v̇` is the second derivative of the force, ω₀ the natural frequency of rotor and screw.
///
/// Where the load changes sign, the gear factor k jumps by at most `1/η − η`, and the inertia
/// `J_m + k·J_s/N²` with it. In the substep with the jump the error is up to a third of its effect,
/// `δF = (1/η − η)·(J_s/N²)·ẇ_m·ω₀·(2πN/ρ)·dt/3`, some 0.2 N in usual motion, which decays with the
/// spring's oscillation. No reasonable substep brings this below [`FORCE_ERROR`].
fn dt_for_force_error(p: &machine_file::Emla, K_b: f64) -> f64 {
    let travel = maps::travel_per_radian(p);
    let w_0_squared = K_b * travel * travel / maps::inertia(p, 1.0);
    let bend = maps::beta_1(p, 0.0) / p.L_d.min(p.L_q) * p.v_max / VOLTAGE_SWEEP;
    (120.0 * FORCE_ERROR / (w_0_squared * bend)).sqrt().sqrt()
}

/// Longest substep for these parameters, s: by the error bound or the fastest mode.
pub(crate) fn longest_substep(p: &machine_file::Emla, drive: Drive) -> f64 {
    let travel = maps::travel_per_radian(p);
    let nut_mass = p.J_m / (travel * travel);
    let K_max = maps::stiffness(p, 0.0).max(maps::stiffness(p, p.L_s));
    let (accurate, mass) = match drive {
        Drive::Motion => (dt_for_force_error(p, K_max), nut_mass),
        Drive::Force => (DT_MAX_FORCE, 1.0 / (1.0 / nut_mass + 1.0 / p.M_act)),
    };
    let rate = fast_rate(mass, p.C_b + p.C_act, K_max)
        .max(p.R_s / p.L_d.min(p.L_q))
        .max(maps::motor_friction_slope(p, 0.0) / p.J_m);
    accurate.min(RATE_STEP / rate)
}
