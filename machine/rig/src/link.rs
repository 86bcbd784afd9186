//! The connection of nut and rod, for `dynamics` and `start`: stiffness of screw, bearings,
//! mounting and pins in series, damping and backlash.

use crate::Rig;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// Force of the nut on the rod, N.
    pub force: f64,
    /// Its derivative by the nut's lead over the rod, N/m; 0 within the backlash.
    pub stiffness: f64,
    /// Energy in the springs, J.
    pub energy: f64,
    /// Power lost, W.
    pub loss: f64,
}

impl Rig {
    /// Stiffness at the rod position `x`, N/m, and its derivative by x.
    ///
    /// Springs in series: the screw between bearing and nut (`x(L_s − x)/(L_s EA)`, both ends
    /// held), two bearings, nut, rod, and the screw's torsion; with `compliance` also mounting with
    /// pins, and the torsion of gear with coupling:
    /// ```text
    /// 1/K = x(L_s − x)/(L_s EA) + 1/(2K_br) + 1/K_n + 1/K_r + (ρ/2π)² x/GJ + 1/K_mount + (ρ/2π)²/K_torsion
    /// ```
    /// Beyond the screw's ends it is constant.
    pub(crate) fn stiffness(&self, x: f64) -> (f64, f64) {
        let (p, lead) = (&self.p, self.lead());
        let inside = x.max(0.0).min(p.L_s);
        let mut sum = inside * (p.L_s - inside) / (p.L_s * p.EA)
            + 0.5 / p.K_br
            + 1.0 / p.K_n
            + 1.0 / p.K_r
            + lead * lead * inside / p.GJ;
        if self.extra.compliance.on {
            sum += self.mounting();
        }
        let by_x = if inside == x {
            (1.0 - 2.0 * x / p.L_s) / p.EA + lead * lead / p.GJ
        } else {
            0.0
        };
        let K = 1.0 / sum;
        (K, -K * K * by_x)
    }

    /// Compliance of mounting, pins, gear and coupling, m/N.
    fn mounting(&self) -> f64 {
        let (c, lead) = (&self.extra.compliance, self.lead());
        1.0 / c.mount + lead * lead / c.torsion
    }

    /// Damping of the whole connection, N·s/m, whose stiffness is `K`, N/m.
    ///
    /// Two parts in series, each a spring with a parallel damper, share the stretch like their
    /// springs as long as it changes slowly compared with `K_part/C_part`; the mounting's share is
    /// σ = K/K_mounting. The dampers then dissipate as much as one damper over both:
    /// ```text
    /// C = C_b (1 − σ)² + C_mount σ²
    /// ```
    /// For the reference actuator this holds to 0.2 % at 6 Hz, and up to some 100 Hz.
    fn damping(&self, K: f64) -> f64 {
        let (C_b, d) = (self.p.C_b, &self.extra.damping);
        if !d.on {
            return C_b;
        }
        let share = if self.extra.compliance.on {
            K * self.mounting()
        } else {
            0.0
        };
        C_b * (1.0 - share) * (1.0 - share) + d.mount * share * share
    }

    /// Half the backlash, m.
    fn play(&self) -> f64 {
        let b = &self.extra.backlash;
        if b.on { 0.5 * b.width } else { 0.0 }
    }

    /// Force for the nut's lead `s` over the rod, m, its rate `s_dot`, rod position `x` and rod
    /// velocity `x_dot`.
    /// ```text
    /// δ = s − b for s > b, s + b for s < −b, else 0;   F = K δ + C ṡ·min(1, |δ|/δ_0), 0 if F δ < 0
    /// ```
    /// and `F = K s + C ṡ` without backlash. The stiffness varies with x, but the force law has no
    /// term for it: a moving rod gains or loses `½ K' ẋ δ²`, counted as a loss.
    #[inline(always)]
    pub(crate) fn link(&self, s: f64, s_dot: f64, x: f64, x_dot: f64) -> Link {
        let (K, K_slope) = self.stiffness(x);
        let (C, play) = (self.damping(K), self.play());
        let deflection = s - s.max(-play).min(play);
        let spring = K * deflection;
        let mut force = spring + C * s_dot;
        if self.extra.backlash.on {
            let engaged = (deflection.abs() / self.extra.backlash.contact).min(1.0);
            force = spring + engaged * C * s_dot;
            if force * spring <= 0.0 {
                force = 0.0;
            }
        }
        Link {
            force,
            stiffness: if deflection == 0.0 && self.extra.backlash.on {
                0.0
            } else {
                K
            },
            energy: 0.5 * spring * deflection,
            loss: (force - spring) * s_dot - 0.5 * K_slope * x_dot * deflection * deflection,
        }
    }

    /// Lead of the nut over the rod at rest under the force `F`, N.
    pub(crate) fn stretch(&self, F: f64, x: f64) -> f64 {
        if F == 0.0 {
            return 0.0;
        }
        F / self.stiffness(x).0 + self.play().copysign(F)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing is transmitted within the play; beyond it the stretch under a force gives that
    /// force; a contact that parts does not pull.
    #[test]
    fn play_transmits_nothing_and_contact_does_not_pull() {
        let rig = Rig::as_built();
        assert_eq!(rig.link(19e-6, 0.3, 0.2, 0.1).force, 0.0);
        for F in [-31e3, 70e3, 5.0] {
            let at_rest = rig.link(rig.stretch(F, 0.2), 0.0, 0.2, 0.0);
            assert!((at_rest.force - F).abs() < 1e-6, "{F}");
        }
        assert_eq!(rig.link(23e-6, -1.0, 0.2, 0.0).force, 0.0);
        assert!(rig.link(23e-6, 0.01, 0.2, 0.0).force > rig.link(23e-6, 0.0, 0.2, 0.0).force);
    }

    /// As built it is softer by mounting and torsion; the slope is the derivative (central
    /// difference).
    #[test]
    fn compliances_add_up() {
        let rig = Rig::as_built();
        let mut plain = rig;
        plain.extra.compliance.on = false;
        let more = 1.0 / rig.stiffness(0.3).0 - 1.0 / plain.stiffness(0.3).0;
        let lead = 0.016 / std::f64::consts::TAU;
        assert!((more - 1.0 / 6e7 - lead * lead / 2e4).abs() < 1e-18);
        let difference = (rig.stiffness(0.3001).0 - rig.stiffness(0.2999).0) / 2e-4;
        assert!((rig.stiffness(0.3).1 / difference - 1.0).abs() < 1e-6);
    }

    /// Two parts in series, each a spring with a parallel damper, yield to a force of frequency ω
    /// by
    /// ```text
    /// Σ 1/(K + jωC) = Σ (K − jωC)/(K² + ω²C²)
    /// ```
    /// so a mass on them has half the ratio of both sums, the loss factor, as its damping ratio
    /// (C. Zener, *Elasticity and Anelasticity of Metals*). One damper over both has it to 1 % at
    /// 5 Hz, where `C_b` over all of them gives five times as much and more.
    #[test]
    fn damping_in_parts_is_that_of_the_parts_in_series() {
        let mut rig = Rig::as_built();
        let (K, w) = (rig.stiffness(0.3).0, std::f64::consts::TAU * 5.0);
        let ratio = |C: f64| 0.5 * w * C / K;
        assert!(ratio(rig.damping(K)) > 0.08);
        for mount in [0.0, 2e4, 6e4] {
            rig.extra.damping = crate::Damping { on: true, mount };
            let stiff = 1.0 / (1.0 / K - rig.mounting());
            let parts = [(stiff, rig.p.C_b), (1.0 / rig.mounting(), mount)];
            let sum = |of: fn(f64, f64) -> f64| -> f64 {
                let share = |&(K, C): &(f64, f64)| of(K, w * C) / (K * K + w * w * C * C);
                parts.iter().map(share).sum()
            };
            let exact = 0.5 * sum(|_, C| C) / sum(|K, _| K);
            let found = ratio(rig.damping(K));
            assert!(
                (found / exact - 1.0).abs() < 0.01,
                "{mount}: {found}, {exact}"
            );
            assert!(found < 0.02, "{mount}: {found}");
        }
    }
}
