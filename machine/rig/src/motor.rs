//! Permanent-magnet synchronous motor in rotor coordinates, for `dynamics` and `start`, with
//! saturation, temperature, flux harmonics and cogging.
//!
//! Source: P. C. Krause, O. Wasynczuk, S. D. Sudhoff, *Analysis of Electric Machinery*, chapter on
//! permanent-magnet machines.

use crate::Rig;
use machine_file::Dq;

/// Flux linkage, resistance and torque of the motor at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Magnetics {
    /// Flux linkage, Wb.
    pub lambda: Dq,
    /// `dλ_q/di_q`, H.
    pub L_inc: f64,
    /// Resistance of a phase, Ω.
    pub R: f64,
    /// Electromagnetic torque, N·m.
    pub tau_e: f64,
    /// Cogging torque, N·m.
    pub tau_cog: f64,
}

impl Rig {
    /// `1/(1 + a·|i_q|)` with `a` such that the share is lost at `i_max`.
    fn saturation_factor(&self, i_q: f64) -> f64 {
        1.0 / (1.0 + self.saturation() * i_q.abs())
    }

    /// `a` of the saturation, 1/A; 0 while it is off.
    fn saturation(&self) -> f64 {
        let s = &self.extra.saturation;
        if s.on {
            s.share / ((1.0 - s.share) * self.p.i_max)
        } else {
            0.0
        }
    }

    /// Resistance of a phase at the winding's temperature, Ω.
    pub(crate) fn resistance(&self, T_winding: f64) -> f64 {
        let t = &self.extra.temperature;
        let rise = if t.on {
            t.copper * (T_winding - t.reference)
        } else {
            0.0
        };
        self.p.R_s * (1.0 + rise)
    }

    /// Flux of the magnets at motor angle and temperature of the housing, which the rotor follows,
    /// Wb: `λ_m·(1 + α_m ΔT)·(1 + r_6 cos 6θ_e + r_12 cos 12θ_e)`.
    pub(crate) fn magnets(&self, theta_e: f64, T_housing: f64) -> f64 {
        let (t, r) = (&self.extra.temperature, &self.extra.ripple);
        let mut flux = self.p.lambda_m;
        if t.on {
            flux *= 1.0 + t.magnet * (T_housing - t.reference);
        }
        if r.on {
            let sixth = libm::cos(6.0 * theta_e);
            flux *= 1.0 + r.sixth * sixth + r.twelfth * (2.0 * sixth * sixth - 1.0);
        }
        flux
    }

    /// ```text
    /// λ_d = L_d i_d + λ_m,   λ_q = L_q i_q/(1 + a|i_q|),   dλ_q/di_q = L_q/(1 + a|i_q|)²
    /// τ_e = 3/2·p·(λ_d i_q − λ_q i_d),   τ_cog = A sin(n θ_m)
    /// ```
    /// The harmonics of λ_m act in the torque and, as back-EMF, in the quadrature-axis voltage, so
    /// power is conserved. The direct-axis voltage by the change of λ_m is neglected together with
    /// its torque.
    #[inline(always)]
    pub(crate) fn magnetics(
        &self,
        i: Dq,
        theta_m: f64,
        T_winding: f64,
        T_housing: f64,
    ) -> Magnetics {
        let p = &self.p;
        let pairs = f64::from(p.p);
        let saturated = self.saturation_factor(i.q);
        let lambda = Dq {
            d: p.L_d * i.d + self.magnets(pairs * theta_m, T_housing),
            q: p.L_q * i.q * saturated,
        };
        Magnetics {
            lambda,
            L_inc: p.L_q * saturated * saturated,
            R: self.resistance(T_winding),
            tau_e: 1.5 * pairs * (lambda.d * i.q - lambda.q * i.d),
            tau_cog: self.cogging(theta_m),
        }
    }

    /// Cogging torque, N·m.
    pub(crate) fn cogging(&self, theta_m: f64) -> f64 {
        let c = &self.extra.cogging;
        if c.on {
            c.torque * libm::sin(c.per_turn * theta_m)
        } else {
            0.0
        }
    }

    /// Energy of the currents' field, J: `3/2·(½ L_d i_d² + ∫ i dλ_q)`.
    ///
    /// `∫ i dλ_q = L_q/a²·(ln(1 + a i) + 1/(1 + a i) − 1)` for i ≥ 0, which is ½ L_q i² for a → 0;
    /// for `a·i` < 1e-3 by its series, whose next term is 1e-9 of it.
    pub(crate) fn field_energy(&self, i: Dq) -> f64 {
        let (p, a) = (&self.p, self.saturation());
        let (size, z) = (i.q.abs(), a * i.q.abs());
        let quadrature = if z < 1e-3 {
            size * size * (0.5 - z * (2.0 / 3.0 - z * 0.75))
        } else {
            (libm::log1p(z) - z / (1.0 + z)) / (a * a)
        };
        1.5 * (0.5 * p.L_d * i.d * i.d + p.L_q * quadrature)
    }

    /// Energy of currents and cogging, J: that of the field, and `(A/n) cos(n θ_m)`.
    pub(crate) fn magnetic_energy(&self, i: Dq, theta_m: f64) -> f64 {
        let c = &self.extra.cogging;
        let cogging = if c.on {
            c.torque / c.per_turn * libm::cos(c.per_turn * theta_m)
        } else {
            0.0
        };
        self.field_energy(i) + cogging
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// λ_q/i_q is a fifth less at i_max, and dλ_q/di_q is the derivative of λ_q (central
    /// difference, h³ error below 1e-9 H).
    #[test]
    fn saturation_takes_its_share_and_its_slope() {
        let rig = Rig::as_built();
        let at = |q: f64| rig.magnetics(Dq { d: -3.0, q }, 0.2, 300.0, 300.0);
        assert!((at(100.0).lambda.q / (100.0 * rig.p.L_q) - 0.8).abs() < 1e-12);
        for q in [-70.0, -3.0, 20.0, 90.0] {
            let slope = (at(q + 1e-3).lambda.q - at(q - 1e-3).lambda.q) / 2e-3;
            assert!((slope - at(q).L_inc).abs() < 1e-9, "{q}");
        }
    }

    /// The energy's derivative by i_q is 3/2·i_q·dλ_q/di_q, by θ_m minus the cogging torque; on
    /// both sides of the series.
    #[test]
    fn the_energy_belongs_to_flux_and_torque() {
        let rig = Rig::as_built();
        let energy = |q: f64, theta: f64| rig.magnetic_energy(Dq { d: 2.0, q }, theta);
        for q in [-80.0, -0.3, 0.2, 0.395, 0.405, 33.0] {
            let h = 1e-3;
            let found = (energy(q + h, 0.3) - energy(q - h, 0.3)) / (2.0 * h);
            let expected = 1.5 * q * rig.magnetics(Dq { d: 2.0, q }, 0.3, 300.0, 300.0).L_inc;
            assert!((found - expected).abs() < 1e-7, "{q}: {found}, {expected}");
        }
        let found = (energy(5.0, 0.3 + 1e-4) - energy(5.0, 0.3 - 1e-4)) / 2e-4;
        assert!((found + rig.cogging(0.3)).abs() < 1e-6);
    }

    /// 60 K warmer: resistance 23.58 % up, magnets 6.6 % down, at an angle without harmonics (cos
    /// 6θ_e + cos 12θ_e = 0 at 6θ_e = π/3).
    #[test]
    fn winding_and_magnets_follow_the_temperature() {
        let rig = Rig::as_built();
        assert!((rig.resistance(353.15) / rig.p.R_s - 1.2358).abs() < 1e-12);
        let angle = std::f64::consts::PI / 18.0;
        assert!((rig.magnets(angle, 353.15) / rig.p.lambda_m - 0.934).abs() < 1e-12);
    }
}
