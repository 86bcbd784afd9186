//! Undervoltage trip, DC-link current and holding brake of an actuator, which both actuator models
//! (`emla` and `rig`) and their FMUs share.

use crate::{Brake, Seconds};

/// Voltage below which the DC link counts as dead, V.
pub const DEAD_LINK: f64 = 1.0;

/// Current, A, for the power `P`, W, from a DC link: `P/v_dc` (V); 0 from a dead link.
pub fn link_current(P: f64, v_dc: f64) -> f64 {
    if v_dc >= DEAD_LINK { P / v_dc } else { 0.0 }
}

/// Whether a drive is tripped at the start of a step. Undervoltage trips an enabled drive; the trip
/// is reset when the drive is disabled and the voltage is back. A disabled drive does not trip.
pub fn is_tripped(before: bool, is_enabled: bool, is_low: bool) -> bool {
    if is_enabled {
        before || is_low
    } else {
        before && is_low
    }
}

/// Warning for a drive that trips at time `t`, s, because `v_dc`, V, is below `undervoltage`, V.
pub fn trip_message(t: f64, v_dc: f64, undervoltage: f64) -> String {
    format!(
        "t = {} s: `v_dc` = {v_dc:.2} V is below `undervoltage` = {undervoltage} V: the drive has tripped, its gates are off and its brake is \
         applied; it works again after `enable` was false with the voltage back",
        Seconds(t)
    )
}

/// State of the holding brake in a substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BrakeState {
    /// The brake is released.
    Released,
    /// It holds the shaft.
    Holds,
    /// It slips, with this torque against the motion, N·m.
    Slips(f64),
}

impl Brake {
    /// How long its torque is still awaited, s, if it was commanded `since` s ago.
    pub fn delay(&self, since: f64) -> f64 {
        (self.closing_time - since).max(0.0)
    }

    /// How long ago it was commanded, s, after a further `h` s under the command; no more than its
    /// closing time, which is reached exactly.
    #[must_use]
    pub fn since(&self, since: f64, h: f64) -> f64 {
        match h < self.delay(since) {
            true => since + h,
            false => self.closing_time,
        }
    }

    /// State of the applied brake on a shaft with speed `w_m`, rad/s: it holds a shaft at rest as
    /// long as the sum of all other torques, N·m, is within its own, and otherwise slips, against
    /// the motion or against the torque that breaks it loose.
    pub fn applied(&self, w_m: f64, others: impl FnOnce() -> f64) -> BrakeState {
        if w_m != 0.0 {
            return BrakeState::Slips(self.torque.copysign(w_m));
        }
        let others = others();
        if others.abs() <= self.torque {
            BrakeState::Holds
        } else {
            BrakeState::Slips(self.torque.copysign(others))
        }
    }
}

impl BrakeState {
    /// Its torque while it slips, N·m; otherwise 0.
    #[must_use]
    pub fn torque(self) -> f64 {
        match self {
            Self::Released | Self::Holds => 0.0,
            Self::Slips(torque) => torque,
        }
    }

    /// Whether the brake, slipping in a substep, has reversed the shaft to the speed `w_m` at its
    /// end: then the shaft came to rest within the substep.
    #[must_use]
    pub fn has_stopped(self, w_m: f64) -> bool {
        self.torque() * w_m < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trip_stays_until_the_drive_is_disabled_with_the_voltage_back() {
        for (before, is_enabled, is_low, after) in [
            (false, true, false, false),
            (false, true, true, true),
            (true, true, false, true),
            (true, false, true, true),
            (true, false, false, false),
            (false, false, true, false),
        ] {
            assert_eq!(is_tripped(before, is_enabled, is_low), after);
        }
    }

    #[test]
    fn a_brake_holds_a_shaft_at_rest_and_slips_against_what_moves_it() {
        let brake = Brake {
            torque: 40.0,
            closing_time: 0.0,
        };
        assert_eq!(brake.applied(0.0, || -39.0), BrakeState::Holds);
        assert_eq!(brake.applied(0.0, || -41.0), BrakeState::Slips(-40.0));
        assert_eq!(brake.applied(-1e-9, || 7.0), BrakeState::Slips(-40.0));
        assert!(
            BrakeState::Slips(-40.0).has_stopped(0.1) && !BrakeState::Slips(40.0).has_stopped(0.1)
        );
        assert!(!BrakeState::Holds.has_stopped(0.1) && !BrakeState::Released.has_stopped(-0.1));
    }

    #[test]
    fn a_dead_link_gives_no_current() {
        assert_eq!(
            (link_current(650.0, 325.0), link_current(650.0, 0.9)),
            (2.0, 0.0)
        );
    }
}
