//! The equations for Model Exchange, where the importer of the FMU `Emla` integrates: derivatives
//! of the state, event indicators, and the state after an event.
//!
//! Quantities that a step of Co-Simulation holds constant are evaluated at the present instant
//! here: temperatures, resistance, flux, and the network's residual. The network's outputs and all
//! means are updated by [`Emla::with_observations`].

use crate::actuator::Emla;
use crate::conditions::Conditions;
use crate::maps;
use crate::state::{LossKinds, State, Thermal};
use machine_file::{ActuatorInput as Input, BrakeState};

/// Number of event indicators: signs of speed, load and torque; undervoltage; the brake.
pub const INDICATORS: usize = 5;

/// How far past its threshold an indicator changes sign, V, N·m and rad/s: an integrator that stops
/// exactly at zero is then past the threshold. Above the rounding of 1 kV.
const OVERSHOOT: f64 = 1e-11;

impl Emla {
    /// The conditions at this instant; an applied brake slips (`slip` = ±1) or holds (0).
    pub(crate) fn instant_conditions<'a>(
        &self,
        p: &'a machine_file::Emla,
        s: &State,
        u: &Input,
        slip: f64,
    ) -> Conditions<'a> {
        let mut held = self.conditions(p, s, u);
        if self.alpha > 0.0 {
            let tau_e = maps::torque(p, s.i_d, s.i_q);
            held.residual = self.alpha * self.residual(tau_e, s.w_m).dF;
        }
        held.brake = match (held.brake, slip) {
            (BrakeState::Released, _) => BrakeState::Released,
            (_, 0.0) => BrakeState::Holds,
            _ => BrakeState::Slips(slip * self.brake().torque),
        };
        held
    }

    /// The time derivative of the state, per s.
    #[must_use]
    pub fn derivative(&self, s: &State, u: &Input, slip: f64) -> State {
        let p = &*self.at_temperature(&s.thermal);
        self.derivative_with(s, u, &self.instant_conditions(p, s, u, slip))
    }

    /// As [`Emla::derivative`], with known conditions.
    pub(crate) fn derivative_with(&self, s: &State, u: &Input, held: &Conditions) -> State {
        let rates = self.rates(&s.point(), u, held);
        let is_counted = self.electric.heat || !held.is_plain(); // as in a step
        State {
            i_d: rates.i.d,
            i_q: rates.i.q,
            theta_m: rates.theta_m,
            w_m: rates.w_m,
            x: rates.x,
            x_dot: rates.x_dot,
            energy: rates.energy,
            kinds: if is_counted {
                rates.kinds
            } else {
                LossKinds::default()
            },
            thermal: self.thermal_rates(s, u, rates.energy.lost, &rates.kinds),
            ..State::default()
        }
    }

    /// Rates of the temperatures and the heat flow to the air, with these losses, W.
    pub(crate) fn thermal_rates(
        &self,
        s: &State,
        u: &Input,
        lost: f64,
        kinds: &LossKinds,
    ) -> Thermal {
        if !self.electric.heat {
            return Thermal::default();
        }
        let other = lost - kinds.copper - kinds.inverter;
        self.temperature_rates(&s.thermal, u.T_ambient, kinds.copper, other)
    }

    /// Event indicators; an event is where one changes sign: motor speed (rad/s), torque on the
    /// screw, whose sign makes the gear factor jump, and electromagnetic torque (N·m); DC-link
    /// voltage above the undervoltage limit (V); of an applied brake, its torque reserve while it
    /// holds (N·m), or the speed at which it slips (rad/s).
    #[must_use]
    pub fn indicators(&self, s: &State, u: &Input, slip: f64) -> [f64; INDICATORS] {
        let p = &*self.at_temperature(&s.thermal);
        let held = self.instant_conditions(p, s, u, slip);
        let now = self.instant(&s.point(), u, &held);
        let above = match self.electric.undervoltage {
            0.0 => 1.0,
            threshold => self.link_voltage(u) - threshold,
        };
        let behind = if s.tripped { -OVERSHOOT } else { OVERSHOOT };
        let brake = match held.brake {
            BrakeState::Released => 1.0,
            BrakeState::Holds => self.brake().torque - now.torque_left.abs() + OVERSHOOT,
            BrakeState::Slips(_) => slip * s.w_m + OVERSHOOT,
        };
        [s.w_m, now.tau_load, now.tau_e, above + behind, brake]
    }

    /// The state after an event, and the direction in which an acting brake slips: a drive that trips
    /// or is disabled loses its currents; a brake holds a shaft that has come to rest, if it can. A
    /// brake that was commanded acts once [`Emla::awaited_brake`] has passed (`closes`).
    #[must_use]
    pub fn after_event(&self, s: &State, u: &Input, slip: f64, closes: bool) -> (State, f64) {
        let mut next = self.update_gates(s, u);
        if closes {
            next.braked = self.braked_after(&next, u, f64::INFINITY);
        }
        if !self.has_brake(&next, u) {
            return (next, 0.0);
        }
        if slip * next.w_m < 0.0 {
            next.energy.lost += 0.5 * maps::inertia(&self.p, 1.0) * next.w_m * next.w_m;
            next.w_m = 0.0;
        }
        let p = &*self.at_temperature(&next.thermal);
        let held = self.instant_conditions(p, &next, u, 0.0);
        let slip = match self.braking(&next.point(), u, &held) {
            BrakeState::Slips(torque) => torque.signum(),
            _ => 0.0,
        };
        (next, slip)
    }

    /// The state with the network's outputs at its torque and speed, and with present values in
    /// place of the means over a step.
    #[must_use]
    pub fn with_observations(&self, s: &State, u: &Input) -> State {
        let p = &*self.at_temperature(&s.thermal);
        let mut next = *s;
        next.residual = self.residual(maps::torque(p, s.i_d, s.i_q), s.w_m);
        let now = self.output(&next, u);
        (next.F_mean, next.P_in_mean, next.i_dc_mean) = (now.F, now.P_in, now.i_dc);
        next
    }
}
