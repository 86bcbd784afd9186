//! Losses by kind (copper, iron, inverter, mechanical), for `dynamics`, `output` and `tangent`.

use crate::actuator::Emla;
use crate::conditions::Conditions;
use crate::instant::Instant;
use crate::maps;
use std::f64::consts::FRAC_2_PI;

/// Losses by kind, W. Their [`Losses::total`] closes the balance
/// `P_in = P_out + losses + d(stored energy)/dt` exactly, before integration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Losses {
    /// Copper, `3/2·R_s·(i_d² + i_q²)`.
    pub copper: f64,
    /// Iron, `(k_h·|w_e| + k_e·w_e²)·(λ_d² + λ_q²)`; a parallel loss without torque. The DC side
    /// supplies it, so it is 0 while the gates are off (neglecting a drag of 0.2 N·m here).
    pub core: f64,
    /// Inverter, conduction `3·(2/π·v_0·i + r_0·i²/2)` and switching `6/π·f_sw·k_sw·v_dc·i` at the
    /// voltage of the DC link.
    pub inverter: f64,
    /// Viscous and Coulomb friction of the motor.
    pub motor_friction: f64,
    /// Gear, `(k − 1)·(J_s ẇ_m/N + τ_load)·w_m/N`.
    pub gear: f64,
    /// Viscous friction of the screw, `C_s·(w_m/N)²`.
    pub screw: f64,
    /// Damping between nut and rod, `C_b·(ẋ_n − ẋ)²`.
    pub nut: f64,
    /// Slipping holding brake, its torque times `w_m`.
    pub brake: f64,
    /// Viscous friction of the rod, `C_act·ẋ²`.
    pub rod: f64,
    /// Power of the network's residual force, `−α·dF·ẋ_n`; of either sign.
    pub residual: f64,
    /// `−½·K_b'(x)·ẋ·(x_n − x)²`, of either sign, some 5·10⁻⁵ of `F·ẋ`: the stiffness varies with
    /// x, for which the paper's force law has no term.
    pub stiffness: f64,
}

impl Losses {
    /// Copper, core and inverter together, W.
    pub fn electrical(&self) -> f64 {
        self.copper + self.core + self.inverter
    }

    /// All but the electrical ones, W.
    pub fn mechanical(&self) -> f64 {
        self.motor_friction
            + self.gear
            + self.screw
            + self.nut
            + self.rod
            + self.residual
            + self.stiffness
            + self.brake
    }

    /// All of them, W.
    pub fn total(&self) -> f64 {
        self.electrical() + self.mechanical()
    }
}

/// Iron loss per squared flux linkage at electrical speed `w_e`, W/Wb², and its derivative by
/// `w_e`; at rest, where it has a kink, the mean of the one-sided derivatives.
pub(crate) fn core_loss(p: &machine_file::Emla, w_e: f64) -> (f64, f64) {
    let Some(machine_file::CoreLosses { k_h, k_e }) = p.core else {
        return (0.0, 0.0);
    };
    let size = w_e.abs();
    (
        (k_h + k_e * size) * size,
        (k_h + 2.0 * k_e * size) * maps::sign(w_e),
    )
}

/// Inverter loss, W, at current amplitude `i`, A, and DC-link voltage `v_dc`, V, and its
/// derivatives by `i`, V, and by `v_dc`, A. Two-level inverter, sinusoidal current: always one
/// device per leg conducts, and the mean of |i| over a period is `2i/π`.
pub(crate) fn inverter_loss(p: &machine_file::Emla, i: f64, v_dc: f64) -> (f64, f64, f64) {
    let Some(c) = p.inverter else {
        return (0.0, 0.0, 0.0);
    };
    let linear = 3.0 * FRAC_2_PI * (c.v_0 + c.f_sw * c.k_sw * v_dc);
    (
        i * (linear + 1.5 * c.r_0 * i),
        linear + 3.0 * c.r_0 * i,
        3.0 * FRAC_2_PI * c.f_sw * c.k_sw * i,
    )
}

impl Emla {
    #[inline(always)]
    pub(crate) fn losses(&self, now: &Instant, held: &Conditions) -> Losses {
        let p = held.p;
        let i2 = now.i.dot(now.i);
        let w_s = 1.0 / p.N_gear * now.w_m;
        let w_s_dot = 1.0 / p.N_gear * now.w_m_dot;
        Losses {
            copper: 1.5 * p.R_s * i2,
            core: if held.gates {
                core_loss(p, now.w_e).0 * now.lambda.dot(now.lambda)
            } else {
                0.0
            },
            inverter: inverter_loss(p, i2.sqrt(), held.v_dc).0,
            motor_friction: now.tau_friction * now.w_m,
            gear: (now.k - 1.0) * (p.J_s * w_s_dot + now.tau_load) * w_s,
            screw: p.C_s * w_s * w_s,
            nut: p.C_b * now.stretch_dot * now.stretch_dot,
            rod: p.C_act * now.x_dot * now.x_dot,
            brake: held.brake.torque() * now.w_m,
            residual: -held.residual * now.x_n_dot,
            stiffness: -0.5 * now.K_b_slope * now.x_dot * now.stretch * now.stretch,
        }
    }
}
