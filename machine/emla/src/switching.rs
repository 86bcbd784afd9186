//! The drive's link voltage, gates, trip and holding brake, for `step`, `continuous` and `output`.

use crate::actuator::Emla;
use crate::conditions::Conditions;
use crate::maps;
use crate::state::{Point, State};
use machine_file::{ActuatorInput as Input, Brake, BrakeState, DEAD_LINK};

impl Emla {
    /// Voltage of the DC link, V: the input's, or the machine's.
    pub fn link_voltage(&self, u: &Input) -> f64 {
        u.v_dc.unwrap_or(self.v_dc)
    }

    /// What stays constant over a step from `s` under `u`; `p`: parameters at `s`'s temperatures.
    #[inline(always)]
    pub(crate) fn conditions<'a>(
        &self,
        p: &'a machine_file::Emla,
        s: &State,
        u: &Input,
    ) -> Conditions<'a> {
        let v_dc = self.link_voltage(u);
        let mut held = Conditions {
            p,
            drive: self.drive,
            v_dc,
            largest: self.p.largest_voltage(v_dc),
            residual: self.alpha * s.residual.dF,
            gates: u.enable && !s.tripped,
            brake: BrakeState::Released,
        };
        if self.has_brake(s, u) {
            held.brake = self.braking(&s.point(), u, &held);
        }
        held
    }

    pub(crate) fn brake(&self) -> Brake {
        self.p.brake.unwrap_or(Brake::TYPICAL)
    }

    /// Whether the brake acts: it is commanded, and its closing time has passed.
    pub(crate) fn has_brake(&self, s: &State, u: &Input) -> bool {
        (u.brake || s.tripped) && self.brake_delay(s) == 0.0
    }

    /// Time until the brake acts, s, if it is commanded.
    #[cold]
    #[inline(never)]
    fn brake_delay(&self, s: &State) -> f64 {
        self.brake().delay(s.braked)
    }

    /// Time until a commanded brake acts, s; 0 while it acts, and without command.
    pub fn awaited_brake(&self, s: &State, u: &Input) -> f64 {
        match u.brake || s.tripped {
            true => self.brake_delay(s),
            false => 0.0,
        }
    }

    /// How long ago the brake was commanded after a further `h` s.
    pub(crate) fn braked_after(&self, s: &State, u: &Input, h: f64) -> f64 {
        match u.brake || s.tripped {
            true => self.brake().since(s.braked, h),
            false => 0.0,
        }
    }

    #[cold]
    pub(crate) fn braking(&self, s: &Point, u: &Input, held: &Conditions) -> BrakeState {
        let free = Conditions {
            brake: BrakeState::Released,
            ..*held
        };
        self.brake()
            .applied(s.w_m, || self.instant(s, u, &free).torque_left)
    }

    /// The state at the start of a step: updates the trip and how long the brake has been commanded,
    /// and clears the currents if gates are off.
    ///
    /// When the gates turn off, the diodes return the currents to the DC link within `L·i/v_dc`,
    /// some 0.1 ms, which is modelled as instantaneous; the field's energy goes into the link (into
    /// the diodes if the link is dead). Then the diodes block, which is valid as long as the
    /// back-EMF `√3·p·|w_m|·λ_m` is below the link's voltage: 3400 rev/min of the reference motor
    /// at 450 V.
    pub(crate) fn update_gates(&self, s: &State, u: &Input) -> State {
        let mut next = *s;
        let v_dc = self.link_voltage(u);
        let low = v_dc < self.electric.undervoltage;
        next.tripped = machine_file::is_tripped(s.tripped, u.enable, low);
        next.braked = self.braked_after(&next, u, 0.0);
        if !u.enable || next.tripped {
            let field = maps::magnetic_energy(&self.p, s.i_d, s.i_q);
            if v_dc >= DEAD_LINK {
                next.energy.supplied -= field;
            } else {
                next.energy.lost += field;
                next.kinds.inverter += field;
            }
            (next.i_d, next.i_q) = (0.0, 0.0);
        }
        next
    }
}
