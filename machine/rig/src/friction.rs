//! Friction of motor, gear, screw and nut (LuGre), and shaft acceleration, for `dynamics`, `step`.
//!
//! Source: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, *A new model for control of
//! systems with friction* (LuGre), IEEE TAC 40(3), 1995; H. Olsson's thesis for a damping that
//! decreases with speed, which keeps the model passive.

use crate::Rig;
use machine_file::BrakeState;

/// Acceleration and losses of the shaft at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shaft {
    /// Motor acceleration, rad/s².
    pub w_m_dot: f64,
    /// Accelerating torque, as if a holding brake were released, N·m.
    pub torque_left: f64,
    /// Power lost between air gap and nut, W.
    pub loss: f64,
}

/// Bristles between nut and screw, which model all dry friction: as the gear is rigid, there is one
/// coordinate.
#[derive(Clone, Copy, Debug)]
struct Bristle {
    /// Force against the nut's motion, N.
    force: f64,
    /// Power that it loses, W.
    loss: f64,
}

impl Rig {
    /// Travel of the nut per radian of the screw, m/rad.
    pub(crate) fn lead(&self) -> f64 {
        self.p.rho / std::f64::consts::TAU
    }

    /// Travel of the nut per radian of the motor, m/rad.
    pub(crate) fn travel(&self) -> f64 {
        self.lead() / self.p.N_gear
    }

    /// Inertia of motor, gear and screw at the motor, kg·m².
    pub(crate) fn inertia(&self) -> f64 {
        self.p.J_m + self.p.J_s / (self.p.N_gear * self.p.N_gear)
    }

    /// Motor acceleration and friction losses at torque `tau`, N·m, speed `w`, rad/s, load `F_nut`,
    /// N, and bristle deflection `z`, m.
    #[inline(always)]
    pub(crate) fn shaft(&self, tau: f64, w: f64, F_nut: f64, z: f64, brake: BrakeState) -> Shaft {
        let mut shaft = if self.extra.friction.on {
            self.dry_shaft(tau - brake.torque(), w, F_nut, z)
        } else {
            self.ideal_shaft(tau - brake.torque(), w, F_nut)
        };
        if brake == BrakeState::Holds {
            shaft.w_m_dot = 0.0;
        }
        shaft.loss += brake.torque() * w;
        shaft
    }

    /// The shaft with dry friction in the bristles and viscous friction:
    /// ```text
    /// J ẇ = τ − (C_m + C_g + C_s/N²) w − c_w|w|w − (ρ/2πN)·(F_nut + F_b),   J = J_m + J_s/N²
    /// ```
    fn dry_shaft(&self, tau: f64, w: f64, F_nut: f64, z: f64) -> Shaft {
        let (p, f, travel) = (&self.p, &self.extra.friction, self.travel());
        let viscous = p.C_m + f.gear_viscous + p.C_s / (p.N_gear * p.N_gear) + f.windage * w.abs();
        let bristle = self.bristle(travel * w, F_nut, z);
        let left = tau - viscous * w - travel * (F_nut + bristle.force);
        Shaft {
            w_m_dot: left / self.inertia(),
            torque_left: left,
            loss: viscous * w * w + bristle.loss,
        }
    }

    /// The shaft with the idealised gear, whose torque ratio k is between η and 1/η:
    /// ```text
    /// (J_m + k J_s/N²) ẇ = τ − C_m w − τ_C tanh(w/w_C) − k τ_s/N,   τ_s = C_s w/N + (ρ/2π) F_nut
    /// k = (1/η + η)/2 + (1/η − η)/2·sign(τ_s)·tanh(w/w_η)
    /// ```
    fn ideal_shaft(&self, tau: f64, w: f64, F_nut: f64) -> Shaft {
        let (p, N) = (&self.p, self.p.N_gear);
        let bearing = p.C_m * w + p.tau_C * libm::tanh(w / p.w_C);
        let screw = p.C_s * w / N + self.lead() * F_nut;
        let sign = if screw == 0.0 { 0.0 } else { screw.signum() };
        let (up, down) = (1.0 / p.eta_gear, p.eta_gear);
        let k = 0.5 * (up + down) + 0.5 * (up - down) * sign * libm::tanh(w / p.w_eta);
        let left = tau - bearing - k * screw / N;
        let w_m_dot = left / (p.J_m + k * p.J_s / (N * N));
        let gear = (k - 1.0) * (p.J_s * w_m_dot / N + screw) * w / N;
        Shaft {
            w_m_dot,
            torque_left: left,
            loss: bearing * w + gear + p.C_s * (w / N) * (w / N),
        }
    }

    /// Falls from 1 at rest to 0 above the Stribeck speed; `v` is the nut's speed, m/s.
    fn slow(&self, v: f64) -> f64 {
        let ratio = v / self.extra.friction.v_stribeck;
        libm::exp(-ratio * ratio)
    }

    /// Dry friction g(v) in steady sliding under the load `F_nut`, N: of bearings, gear, preloaded
    /// screw and seals, and the load-dependent part of screw and mesh; at rest the breakaway force. The
    /// nut moves in the `direction` 1 (out) or −1.
    fn sliding(&self, F_nut: f64, slow: f64, direction: f64) -> f64 {
        let (p, f) = (&self.p, &self.extra.friction);
        let idle = (p.tau_C + f.gear_drag) / self.travel() + f.screw_drag / self.lead() + f.seal;
        // |F| with a round corner at 0.
        let load = F_nut * F_nut / (F_nut * F_nut + f.f_smooth * f.f_smooth).sqrt();
        let coulomb = idle + (f.screw_loss + f.gear_loss) * load;
        coulomb * (1.0 + f.asymmetry * direction) * (1.0 + (f.breakaway - 1.0) * slow)
    }

    /// ```text
    /// ż = v − σ_0|v|/g(v)·z,   F_b = σ_0 z + σ_1(v) ż,   loss = F_b v − σ_0 z ż
    /// ```
    fn bristle(&self, v: f64, F_nut: f64, z: f64) -> Bristle {
        let f = &self.extra.friction;
        let slow = self.slow(v);
        let z_dot = v - f.stiffness * v.abs() / self.sliding(F_nut, slow, v.signum()) * z;
        let force = f.stiffness * z + f.damping * slow * z_dot;
        Bristle {
            force,
            loss: force * v - f.stiffness * z * z_dot,
        }
    }

    /// Bristle deflection after `dt` s at constant nut speed `v` and load `F_nut` (exact): an
    /// exponential approach to `g(v)/σ_0` in the direction of motion, over a distance of that
    /// length.
    pub(crate) fn deflection_after(&self, z: f64, v: f64, F_nut: f64, dt: f64) -> f64 {
        if !self.extra.friction.on {
            return 0.0;
        }
        let sliding = self.sliding(F_nut, self.slow(v), v.signum()) / self.extra.friction.stiffness;
        let share = -libm::expm1(-v.abs() * dt / sliding);
        z + share * (sliding.copysign(v) - z)
    }

    /// Bristle deflection in steady motion at nut speed `v`, m.
    pub(crate) fn steady_deflection(&self, v: f64, F_nut: f64) -> f64 {
        if !self.extra.friction.on || v == 0.0 {
            return 0.0;
        }
        (self.sliding(F_nut, self.slow(v), v.signum()) / self.extra.friction.stiffness).copysign(v)
    }

    /// Energy in the bristles, J.
    pub(crate) fn bristle_energy(&self, z: f64) -> f64 {
        0.5 * self.extra.friction.stiffness * z * z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Friction of the rig at rest and far beyond the Stribeck speed, unloaded and under 40 kN:
    /// sums of what the parameters say.
    #[test]
    fn breakaway_is_its_factor_times_coulomb() {
        let rig = Rig::as_built();
        let travel = 0.016 / std::f64::consts::TAU / 6.0;
        let idle = (0.6 + 0.14) / travel + 0.5 / (6.0 * travel) + 260.0;
        assert!((rig.sliding(0.0, 0.0, 1.0) - idle).abs() < 1e-9);
        let loaded = rig.sliding(40e3, 0.0, 1.0);
        assert!((loaded - idle - 0.076 * 40e3).abs() < 1.0, "{loaded}"); // the corner leaves 0.3 ‰
        assert!((rig.sliding(40e3, rig.slow(0.0), 1.0) / loaded - 1.3).abs() < 1e-12);
    }

    /// Steady friction out and in has the ratio (1 + a)/(1 − a), and a mean as without a.
    #[test]
    fn friction_may_depend_on_the_direction() {
        let mut rig = Rig::as_built();
        let even = rig.steady_deflection(0.05, 20e3);
        rig.extra.friction.asymmetry = 0.2;
        let [out, inward] = [0.05, -0.05].map(|v| rig.steady_deflection(v, 20e3).abs());
        assert!((out / inward - 1.5).abs() < 1e-12);
        assert!((0.5 * (out + inward) / even - 1.0).abs() < 1e-12);
    }

    /// The exact step is that of a thousand parts of it, and of the differential equation (midpoint
    /// rule: error (dt/1000)²).
    #[test]
    fn the_exact_deflection_solves_its_equation() {
        let rig = Rig::as_built();
        for v in [0.07, -0.07, -0.002, 0.0] {
            let (z, F, dt) = (6e-6, 31e3, 3e-4);
            let once = rig.deflection_after(z, v, F, dt);
            let (mut parts, mut midpoint) = (z, z);
            let rate = |z: f64| {
                let bristle = rig.bristle(v, F, z);
                let slope = rig.extra.friction.damping * rig.slow(v);
                // z_dot from the force: (F_b − σ_0 z)/σ_1, or by the steady state where σ_1 has
                // faded.
                if slope > 1.0 {
                    (bristle.force - rig.extra.friction.stiffness * z) / slope
                } else {
                    v * (1.0 - z / rig.steady_deflection(v, F))
                }
            };
            for _ in 0..1000 {
                let h = dt / 1000.0;
                parts = rig.deflection_after(parts, v, F, h);
                midpoint += h * if v == 0.0 {
                    0.0
                } else {
                    rate(midpoint + 0.5 * h * rate(midpoint))
                };
            }
            assert!((once - parts).abs() < 1e-17, "{v}");
            assert!((once - midpoint).abs() < 1e-11, "{v}: {once}, {midpoint}");
        }
    }

    /// Friction never gives energy: the bristles' loss is not negative at any speed, load and
    /// deflection up to their largest.
    #[test]
    fn friction_is_passive() {
        let rig = Rig::as_built();
        for k in -400..=400 {
            let v = 0.5 * (f64::from(k) / 400.0).powi(3);
            for F in [0.0, 5e3, -70e3] {
                let largest = rig.sliding(F, 1.0, 1.0) / rig.extra.friction.stiffness;
                for part in [-1.0, -0.6, -0.1, 0.0, 0.3, 0.9, 1.0] {
                    let loss = rig.bristle(v, F, part * largest).loss;
                    assert!(loss >= -1e-9, "v = {v}, F = {F}, part {part}: {loss} W");
                }
            }
        }
    }
}
