//! Equations of motion: from state and inputs to everything that holds at one instant, and the rates.

use crate::heat::{Kinds, Thermal};
use crate::held::Held;
use crate::input::Input;
use crate::losses::Losses;
use crate::maps;
use crate::motor::{self, Dq};
use crate::residual::Residual;
use crate::{Drive, Emla};
use machine::Holding;
use serde::{Deserialize, Serialize};

/// Everything that changes while the actuator runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Direct-axis current, A (peak).
    pub i_d: f64,
    /// Quadrature-axis current, A (peak).
    pub i_q: f64,
    /// Motor angle, rad; the nut stands at `x_n = ρ/(2πN)·θ_m`.
    pub theta_m: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Rod position in [`Drive::Force`], m; stays at its start value in [`Drive::Motion`].
    pub x: f64,
    /// Rod velocity in [`Drive::Force`], m/s; stays at its start value in [`Drive::Motion`].
    pub x_dot: f64,
    /// What the network adds to the force; of the state's torque and speed, held over the next step.
    pub residual: Residual,
    /// Mean of the force on the load over the last step, N; at the start that force itself.
    pub F_mean: f64,
    /// Mean of the power from the DC side over the last step, W; at the start that power itself.
    pub P_in_mean: f64,
    /// Mean of the current from the DC side over the last step, A; at the start that current itself.
    pub i_dc_mean: f64,
    /// Time by which [`crate::Output::F`] is given ahead, s.
    pub lead: f64,
    /// Energies since the start.
    pub energy: Energy,
    /// Work on the load by shifts of the rod between steps since the start, J: see [`crate::Emla::work_of_shift`].
    pub shift: f64,
    /// Losses by where their heat goes.
    pub kinds: Kinds,
    /// Temperatures.
    pub thermal: Thermal,
    /// Whether undervoltage has tripped the drive: gates off, brake applied.
    pub tripped: bool,
}

/// Energies since the start, J; as a rate: powers, W.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Taken from the DC side, core and inverter losses included.
    pub supplied: f64,
    /// Given to the load.
    pub delivered: f64,
    /// Lost.
    pub lost: f64,
}

impl Energy {
    fn advanced(self, dt: f64, power: Self) -> Self {
        Self {
            supplied: self.supplied + dt * power.supplied,
            delivered: self.delivered + dt * power.delivered,
            lost: self.lost + dt * power.lost,
        }
    }
}

/// The part of the [`State`] that is integrated from substep to substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Point {
    pub i_d: f64,
    pub i_q: f64,
    pub theta_m: f64,
    pub w_m: f64,
    pub x: f64,
    pub x_dot: f64,
    /// Integral of the force on the load, N·s.
    pub impulse: f64,
    pub energy: Energy,
}

/// Time derivative of a [`Point`]; `F` is that of the impulse.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rates {
    pub i: Dq,
    pub theta_m: f64,
    pub w_m: f64,
    pub x: f64,
    pub x_dot: f64,
    pub F: f64,
    pub energy: Energy,
    pub kinds: Kinds,
}

impl State {
    pub(crate) fn point(&self) -> Point {
        Point {
            i_d: self.i_d,
            i_q: self.i_q,
            theta_m: self.theta_m,
            w_m: self.w_m,
            x: self.x,
            x_dot: self.x_dot,
            impulse: 0.0,
            energy: self.energy,
        }
    }
}

impl Point {
    /// `self + dt·rates`; `rates.kinds` are not part of it.
    #[inline(always)]
    pub(crate) fn advanced(&self, dt: f64, rates: &Rates) -> Self {
        Self {
            i_d: self.i_d + dt * rates.i.d,
            i_q: self.i_q + dt * rates.i.q,
            theta_m: self.theta_m + dt * rates.theta_m,
            w_m: self.w_m + dt * rates.w_m,
            x: self.x + dt * rates.x,
            x_dot: self.x_dot + dt * rates.x_dot,
            impulse: self.impulse + dt * rates.F,
            energy: self.energy.advanced(dt, rates.energy),
        }
    }

    pub(crate) fn current(&self) -> Dq {
        Dq {
            d: self.i_d,
            q: self.i_q,
        }
    }
}

/// What follows from state and inputs at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instant {
    /// Voltage after the limit, V.
    pub v: Dq,
    /// Current, A.
    pub i: Dq,
    /// Flux linkage, Wb.
    pub lambda: Dq,
    /// Electrical speed, rad/s.
    pub w_e: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Electromagnetic torque, N·m.
    pub tau_e: f64,
    /// Rod position, m.
    pub x: f64,
    /// Rod velocity, m/s.
    pub x_dot: f64,
    /// Nut velocity, m/s.
    pub x_n_dot: f64,
    /// Stiffness between nut and rod, N/m.
    pub K_b: f64,
    /// Its derivative by x, N/m².
    pub K_b_slope: f64,
    /// `x_n − x`, m.
    pub stretch: f64,
    /// `x_n_dot − x_dot`, m/s.
    pub stretch_dot: f64,
    /// Force on the load, N.
    pub F: f64,
    /// Friction of the motor, N·m.
    pub tau_friction: f64,
    /// Torque of friction and nut on the screw, N·m.
    pub tau_load: f64,
    /// Gear factor.
    pub k: f64,
    /// What is left to accelerate, but for a brake that holds, N·m.
    pub torque_left: f64,
    /// Motor acceleration, rad/s².
    pub w_m_dot: f64,
}

impl Emla {
    /// Everything at one instant.
    ///
    /// Source: `[paper]` Eq. (eq:backdrive_torque) for the spring; Eq. (eq:rotor_dynamics), Eq. (eq:gear_torque) and
    /// Eq. (eq:screw_dynamics) merged into one equation, because a rigid gear has one degree of freedom:
    /// ```text
    /// F_spring = C_b (ẋ_n − ẋ) + K_b(x)·(x_n − x),   F = F_spring − C_act ẋ,   F_nut = F_spring − α·dF
    /// (J_m + k J_s/N²) ẇ_m = τ_e − C_m w_m − τ_C tanh(w_m/w_C) − k (C_s w_m/N + lead·F_nut)/N
    /// ```
    #[inline(always)] // so that what depends on parameters only moves out of the loops of a step
    pub(crate) fn instant(&self, s: &Point, u: &Input, held: &Held) -> Instant {
        let p = held.p;
        let (x, x_dot) = match held.drive {
            Drive::Motion => (u.x, u.x_dot),
            Drive::Force => (s.x, s.x_dot),
        };
        let (i, w_m) = (s.current(), s.w_m);
        let travel = maps::travel_per_radian(p);
        let x_n_dot = travel * w_m;
        let (stretch, stretch_dot) = (travel * s.theta_m - x, x_n_dot - x_dot);
        let (K_b, K_b_slope) = maps::stiffness_and_slope(p, x);
        let F_spring = p.C_b * stretch_dot + K_b * stretch;
        let F_nut = F_spring - held.residual;
        let tau_load = maps::screw_load(p, F_nut, w_m);
        let k = maps::gear_factor(p, tau_load, w_m);
        let tau_e = maps::torque(p, i.d, i.q);
        let tau_friction = maps::motor_friction(p, w_m);
        let mut torque_left = tau_e - tau_friction - 1.0 / p.N_gear * (k * tau_load);
        let mut v = motor::limited(held.largest, Dq { d: u.v_d, q: u.v_q });
        let mut w_m_dot = torque_left / maps::inertia(p, k);
        if !held.is_plain() {
            torque_left -= held.brake.torque();
            w_m_dot = match held.brake {
                Holding::Holds => 0.0,
                _ => torque_left / maps::inertia(p, k),
            };
            if !held.gates {
                v = Dq::default();
            }
        }
        Instant {
            v,
            i,
            lambda: motor::flux(p, i),
            w_e: f64::from(p.p) * w_m,
            w_m,
            tau_e,
            x,
            x_dot,
            x_n_dot,
            K_b,
            K_b_slope,
            stretch,
            stretch_dot,
            F: F_spring - p.C_act * x_dot,
            tau_friction,
            tau_load,
            k,
            torque_left,
            w_m_dot,
        }
    }

    /// Time derivative of the state.
    ///
    /// The rod, in [`Drive::Force`], by Eq. (eq:rod_dynamics):
    /// ```text
    /// M_act ẍ + C_act ẋ + C_b (ẋ − ẋ_n) + K_b (x − x_n) = −F_ext
    /// ```
    #[inline(always)]
    pub(crate) fn rates(&self, s: &Point, u: &Input, held: &Held) -> Rates {
        let p = held.p;
        let now = self.instant(s, u, held);
        let (x, x_dot) = match held.drive {
            Drive::Motion => (0.0, 0.0),
            Drive::Force => (s.x_dot, (now.F - u.F_ext) / p.M_act),
        };
        let losses = self.losses(&now, held);
        let i = if held.gates {
            motor::di_dt(p, now.v, now.i, now.lambda, now.w_e)
        } else {
            Dq::default()
        };
        Rates {
            i,
            theta_m: s.w_m,
            w_m: now.w_m_dot,
            x,
            x_dot,
            F: now.F,
            energy: Energy {
                supplied: power_in(&now, &losses),
                delivered: power_out(held.drive, &now, u),
                lost: losses.total(),
            },
            kinds: Kinds {
                copper: losses.copper,
                inverter: losses.inverter,
            },
        }
    }

    /// Work on the load, J, when the rod of [`Drive::Motion`] is set from position `from` to `to`, both m, between two steps in state `s`.
    ///
    /// Whoever prescribes the motion gives a velocity for a step, and then the position that came of it; the rod jumps by the
    /// difference, `½·a·h²`, and what the spring gives or takes thereby crosses the border outside of every step: it belongs to
    /// `energy.in = energy.out + shift + energy.loss + Δenergy.stored`. Over a motion from rest to rest it nearly cancels; where a brake
    /// stops the shaft it does not.
    #[must_use]
    pub fn work_of_shift(&self, s: &State, from: f64, to: f64) -> f64 {
        let nut = maps::travel_per_radian(&self.p) * s.theta_m;
        let elastic = |x: f64| 0.5 * maps::stiffness(&self.p, x) * (nut - x) * (nut - x);
        match self.drive {
            Drive::Motion if from != to => elastic(from) - elastic(to),
            _ => 0.0,
        }
    }

    /// Energy in magnetic field, rotor and screw, spring, and (in [`Drive::Force`]) rod, J.
    pub(crate) fn stored(&self, now: &Instant) -> f64 {
        let p = &self.p;
        let magnetic = maps::magnetic_energy(p, now.i.d, now.i.q);
        let rotating = 0.5 * maps::inertia(p, 1.0) * now.w_m * now.w_m;
        let elastic = 0.5 * now.K_b * now.stretch * now.stretch;
        let rod = match self.drive {
            Drive::Motion => 0.0,
            Drive::Force => 0.5 * p.M_act * now.x_dot * now.x_dot,
        };
        magnetic + rotating + elastic + rod
    }
}

/// Electrical power from the DC side, W: `3/2·(v_d i_d + v_q i_q) + P_core + P_inverter`.
pub(crate) fn power_in(now: &Instant, losses: &Losses) -> f64 {
    1.5 * now.v.dot(now.i) + losses.core + losses.inverter
}

/// Power given to the load, W: what crosses the actuator's mechanical border, which lies before
/// the rod's mass in [`Drive::Motion`] and behind it in [`Drive::Force`].
pub(crate) fn power_out(drive: Drive, now: &Instant, u: &Input) -> f64 {
    match drive {
        Drive::Motion => now.F * now.x_dot,
        Drive::Force => u.F_ext * now.x_dot,
    }
}
