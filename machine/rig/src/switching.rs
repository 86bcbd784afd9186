//! The drive's discrete states for `step` and `start`: gates, undervoltage trip, holding brake.

use crate::conditions::Conditions;
use crate::rig::Rig;
use crate::state::{HeldVoltages, State};
use machine_file::{ActuatorInput as Input, Brake, BrakeState, DEAD_LINK, is_tripped};

impl Rig {
    /// The conditions in state `s` under the inputs `u`.
    pub(crate) fn conditions(&self, s: &State, u: &Input) -> Conditions {
        let mut held = Conditions {
            gates: u.enable && !s.tripped,
            brake: BrakeState::Released,
        };
        if self.awaited_brake(s, u) == Some(0.0) {
            held.brake = self.braking(s, u, held.gates);
        }
        held
    }

    fn brake(&self) -> Brake {
        self.p.brake.unwrap_or(Brake::TYPICAL)
    }

    /// Time until a commanded brake acts, s; 0 while it acts.
    pub(crate) fn awaited_brake(&self, s: &State, u: &Input) -> Option<f64> {
        (u.brake || s.tripped).then(|| self.brake().delay(s.braked))
    }

    /// How long ago the brake was commanded after a further `h` s.
    pub(crate) fn braked_after(&self, s: &State, u: &Input, h: f64) -> f64 {
        match u.brake || s.tripped {
            true => self.brake().since(s.braked, h),
            false => 0.0,
        }
    }

    #[cold]
    fn braking(&self, s: &State, u: &Input, gates: bool) -> BrakeState {
        let free = Conditions {
            gates,
            brake: BrakeState::Released,
        };
        self.brake()
            .applied(s.w_m, || self.instant(s, u, &free).shaft.torque_left)
    }

    /// The state at the start of a step: updates the undervoltage trip and how long the brake has been
    /// commanded, and sets currents and held
    /// voltages to 0 if the gates are off.
    ///
    /// When the gates turn off, the diodes return the currents to the DC link within `L·i/v_dc`,
    /// less than a switching period, which is modelled as instantaneous: the field's energy goes
    /// into the link, or into the diodes if the link is dead. Then the diodes block, as long as the
    /// back-EMF `√3·p·|w_m|·λ_m` is below the link's voltage.
    pub(crate) fn update_gates(&self, s: &State, u: &Input) -> State {
        let mut next = *s;
        next.tripped = is_tripped(
            s.tripped,
            u.enable,
            self.link_voltage(u) < self.undervoltage,
        );
        next.braked = self.braked_after(&next, u, 0.0);
        if u.enable && !next.tripped {
            return next;
        }
        let field = self.field_energy(s.current());
        if self.link_voltage(u) >= DEAD_LINK {
            next.energy.supplied -= field;
        } else {
            next.energy.lost += field;
            next.energy.inverter += field;
        }
        (next.i_d, next.i_q) = (0.0, 0.0);
        next.hold = HeldVoltages::default();
        next.regulator = [0.0; 2];
        next
    }

    /// The state after a substep; if a slipping brake has reversed the shaft, the shaft stops and
    /// the rest of its kinetic energy heats the housing.
    pub(crate) fn stop_if_reversed(&self, s: State, held: &Conditions) -> State {
        if !held.brake.has_stopped(s.w_m) {
            return s;
        }
        let left = 0.5 * self.inertia() * s.w_m * s.w_m;
        let mut next = s;
        next.w_m = 0.0;
        next.energy.lost += left;
        if self.extra.heat.on {
            next.T[1] += left / self.extra.heat.C_h;
        }
        next
    }
}
