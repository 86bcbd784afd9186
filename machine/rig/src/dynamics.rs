//! Forces, powers and losses at an instant, and the state's derivative, for `step` and `output`.

use crate::conditions::Conditions;
use crate::friction::Shaft;
use crate::heat::ThermalRates;
use crate::link::Link;
use crate::motor::Magnetics;
use crate::state::{Balance, Rates};
use crate::{Drive, Input, Rig, State};
use machine_file::Dq;

/// Quantities that follow from state and inputs at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instant {
    /// Voltage at the motor, V.
    pub v: Dq,
    pub magnetics: Magnetics,
    /// Rod position, m, and velocity, m/s.
    pub x: f64,
    pub x_dot: f64,
    /// `ẋ_n − ẋ`, m/s.
    pub s_dot: f64,
    pub link: Link,
    pub shaft: Shaft,
    /// Force on the load, N.
    pub F: f64,
    /// Losses by kind, W.
    pub copper: f64,
    pub core: f64,
    pub inverter: f64,
    pub mechanical: f64,
    /// Power to the load, W.
    pub delivered: f64,
    pub warming: ThermalRates,
}

impl Instant {
    /// All losses, W.
    pub(crate) fn lost(&self) -> f64 {
        self.copper + self.core + self.inverter + self.mechanical
    }

    /// Power from the DC side, W: `3/2·(v_d i_d + v_q i_q)` plus iron and inverter losses.
    pub(crate) fn supplied(&self, i: Dq) -> f64 {
        1.5 * self.v.dot(i) + self.core + self.inverter
    }
}

impl Rig {
    pub(crate) fn rod(&self, s: &State, u: &Input) -> (f64, f64) {
        match self.drive {
            Drive::Motion => (u.x, u.x_dot),
            Drive::Force => (s.x, s.x_dot),
        }
    }

    /// Connection of nut and rod, and the nut's velocity relative to the rod, m/s.
    #[inline(always)]
    pub(crate) fn link_at(&self, s: &State, u: &Input) -> (Link, f64) {
        let ((x, x_dot), travel) = (self.rod(s, u), self.travel());
        let s_dot = travel * s.w_m - x_dot;
        (self.link(travel * s.theta_m - x, s_dot, x, x_dot), s_dot)
    }

    /// ```text
    /// F = F_link − C_act ẋ,   P_out = F ẋ (rod moved from outside) or F_ext ẋ (free rod)
    /// P_iron = (k_h|ω_e| + k_e ω_e²)(λ_d² + λ_q²),   P_copper = 3/2·R|i|²
    /// P_inverter = 3·(2/π·(v_0 + k_sw f_sw v_dc)·|i| + r_0|i|²/2)
    /// ```
    /// The DC side supplies the iron losses, so there are none while the gates are off.
    #[inline(always)]
    pub(crate) fn instant(&self, s: &State, u: &Input, held: &Conditions) -> Instant {
        let (p, i) = (&self.p, s.current());
        let (x, x_dot) = self.rod(s, u);
        let magnetics = self.magnetics(i, s.theta_m, s.T[0], s.T[1]);
        let (link, s_dot) = self.link_at(s, u);
        let torque = magnetics.tau_e + magnetics.tau_cog;
        let shaft = self.shaft(torque, s.w_m, link.force, s.z, held.brake);
        let F = link.force - p.C_act * x_dot;
        let copper = 1.5 * magnetics.R * i.dot(i);
        let core = if held.gates {
            self.core(magnetics.lambda, s.w_m)
        } else {
            0.0
        };
        let mechanical = shaft.loss + link.loss + p.C_act * x_dot * x_dot;
        Instant {
            v: if held.gates {
                self.voltage(&s.hold, u, i, s.theta_m)
            } else {
                Dq::default()
            },
            magnetics,
            x,
            x_dot,
            s_dot,
            link,
            shaft,
            F,
            copper,
            core,
            inverter: self.inverter(i, self.link_voltage(u)),
            mechanical,
            delivered: match self.drive {
                Drive::Motion => F * x_dot,
                Drive::Force => u.F_ext * x_dot,
            },
            warming: self.temperature_rates(s.T, u.T_ambient, copper, core + mechanical),
        }
    }

    fn core(&self, lambda: Dq, w_m: f64) -> f64 {
        let Some(c) = self.p.core else { return 0.0 };
        let w_e = f64::from(self.p.p) * w_m.abs();
        let losses = &self.extra.losses;
        let factor = if losses.on { losses.core } else { 1.0 };
        factor * (c.k_h + c.k_e * w_e) * w_e * lambda.dot(lambda)
    }

    fn inverter(&self, i: Dq, v_dc: f64) -> f64 {
        let Some(c) = self.p.inverter else { return 0.0 };
        let losses = &self.extra.losses;
        let factor = if losses.on { losses.inverter } else { 1.0 };
        let size = i.dot(i).sqrt();
        let drop = std::f64::consts::FRAC_2_PI * (c.v_0 + c.k_sw * c.f_sw * v_dc);
        factor * 3.0 * size * (drop + 0.5 * c.r_0 * size)
    }

    /// Time derivative of the state, bristles and inverter held:
    /// ```text
    /// L_d di_d/dt = v_d − R i_d + ω_e λ_q,   dλ_q/di_q·di_q/dt = v_q − R i_q − ω_e λ_d
    /// M_act ẍ = F − F_ext (free rod)
    /// ```
    #[inline(always)]
    pub(crate) fn rates(&self, s: &State, u: &Input, held: &Conditions) -> Rates {
        let (p, i, now) = (&self.p, s.current(), self.instant(s, u, held));
        let Magnetics {
            lambda, L_inc, R, ..
        } = now.magnetics;
        let w_e = f64::from(p.p) * s.w_m;
        let (x, x_dot) = match self.drive {
            Drive::Motion => (0.0, 0.0),
            Drive::Force => (s.x_dot, (now.F - u.F_ext) / p.M_act),
        };
        Rates {
            i: if held.gates {
                Dq {
                    d: (now.v.d - R * i.d + w_e * lambda.q) / p.L_d,
                    q: (now.v.q - R * i.q - w_e * lambda.d) / L_inc,
                }
            } else {
                Dq::default()
            },
            theta_m: s.w_m,
            w_m: now.shaft.w_m_dot,
            x,
            x_dot,
            T: [now.warming.T_winding, now.warming.T_housing],
            F: now.F,
            energy: Balance {
                supplied: now.supplied(i),
                delivered: now.delivered,
                lost: now.lost(),
                inverter: now.inverter,
                heat: now.warming.given,
            },
        }
    }

    /// Work on the load, J, when the rod of [`Drive::Motion`] is set from position `from` to `to`,
    /// both m, between two steps in state `s`: the energy that the springs release.
    pub fn work_of_shift(&self, s: &State, from: f64, to: f64) -> f64 {
        let nut = self.travel() * s.theta_m;
        let elastic = |x: f64| self.link(nut - x, 0.0, x, 0.0).energy;
        match self.drive {
            Drive::Motion if from != to => elastic(from) - elastic(to),
            _ => 0.0,
        }
    }

    /// Energy in field, cogging, rotating parts, springs, bristles and free rod, J.
    pub(crate) fn stored(&self, s: &State, now: &Instant) -> f64 {
        let magnetic = self.magnetic_energy(s.current(), s.theta_m);
        let rotating = 0.5 * self.inertia() * s.w_m * s.w_m;
        let rod = match self.drive {
            Drive::Motion => 0.0,
            Drive::Force => 0.5 * self.p.M_act * now.x_dot * now.x_dot,
        };
        magnetic + rotating + now.link.energy + self.bristle_energy(s.z) + rod
    }
}
