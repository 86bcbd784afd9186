//! The state's derivative, powers and energies at an instant, for `step`, `continuous`, `output`.

use crate::actuator::Emla;
use crate::conditions::Conditions;
use crate::instant::Instant;
use crate::losses::Losses;
use crate::state::{Balance, LossKinds, Point, Rates, State};
use crate::{maps, motor};
use machine_file::{ActuatorInput as Input, Dq, Drive};

impl Emla {
    /// Time derivative of the state.
    ///
    /// The rod, in [`Drive::Force`], by Eq. (eq:rod_dynamics):
    /// ```text
    /// M_act ẍ + C_act ẋ + C_b (ẋ − ẋ_n) + K_b (x − x_n) = −F_ext
    /// ```
    #[inline(always)]
    pub(crate) fn rates(&self, s: &Point, u: &Input, held: &Conditions) -> Rates {
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
            energy: Balance {
                supplied: power_in(&now, &losses),
                delivered: power_out(held.drive, &now, u),
                lost: losses.total(),
            },
            kinds: LossKinds {
                copper: losses.copper,
                inverter: losses.inverter,
            },
        }
    }

    /// Work on the load, J, when the rod of [`Drive::Motion`] is set from position `from` to `to`,
    /// both m, between two steps in state `s`.
    ///
    /// An importer that prescribes the motion sets a velocity for a step and afterwards the
    /// position that the rod has reached. The two differ by `½·a·h²`, by which the rod jumps. The
    /// spring's energy in the jump is the shift in
    /// `energy.in = energy.out + shift + energy.loss + Δenergy.stored`. Over a motion from rest to
    /// rest it nearly cancels, unless a brake stops the shaft.
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

/// Power to the load, W: that of the force on the rod in [`Drive::Motion`], whose mass belongs to
/// the load, and of the external force in [`Drive::Force`].
pub(crate) fn power_out(drive: Drive, now: &Instant, u: &Input) -> f64 {
    match drive {
        Drive::Motion => now.F * now.x_dot,
        Drive::Force => u.F_ext * now.x_dot,
    }
}
