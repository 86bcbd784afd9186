//! The drive's states: whether its gates are on, whether it has tripped, and what its brake does.

use crate::conditions::Conditions;
use crate::rig::Rig;
use crate::state::{HeldVoltages, State};
use machine_file::{ActuatorInput as Input, DEAD_LINK, Holding, is_tripped};

impl Rig {
    /// What holds in state `s` under the inputs `u`.
    pub(crate) fn conditions(&self, s: &State, u: &Input) -> Conditions {
        let mut held = Conditions {
            gates: u.enable && !s.tripped,
            brake: Holding::Released,
        };
        if u.brake || s.tripped {
            held.brake = self.braking(s, u, held.gates);
        }
        held
    }

    /// What an applied brake does at this point.
    #[cold]
    fn braking(&self, s: &State, u: &Input, gates: bool) -> Holding {
        let free = Conditions {
            gates,
            brake: Holding::Released,
        };
        let brake = self.p.brake.unwrap_or(machine_file::Brake::TYPICAL);
        brake.applied(s.w_m, || self.instant(s, u, &free).shaft.torque_left)
    }

    /// The state as a step begins: whether the drive trips, or a trip is taken back, and without
    /// current and held voltages where the gates are off.
    ///
    /// When the gates go off, the diodes return the currents to the DC link against its voltage.
    /// This takes `L·i/v_dc`, less than a switching period, and is taken to be over at once: the
    /// field's energy goes back into the link, or into the diodes where the link is dead. From then
    /// on the diodes block, as long as the back-EMF `√3·p·|w_m|·λ_m` stays below the link's
    /// voltage.
    pub(crate) fn update_gates(&self, s: &State, u: &Input) -> State {
        let mut next = *s;
        next.tripped = is_tripped(
            s.tripped,
            u.enable,
            self.link_voltage(u) < self.undervoltage,
        );
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

    /// The state after a substep, in which a brake that slipped has turned the shaft back: it came
    /// to rest inside. What is left of its energy is lost there, as heat of the housing.
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
