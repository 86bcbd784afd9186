//! The equations for Model Exchange, where the importer of the FMU `DcLink` integrates: derivatives
//! of the state, event indicators, and the mode after an event.

use crate::circuit::Point;
use crate::input::Input;
use crate::link::DcLink;
use crate::state::{Energies, State};

/// Event indicators: the guards of a mode, and the two voltages at which a warning is due.
pub const ENDS: usize = 6;

/// How far past the end of a mode its indicator changes sign, V and A: an integrator that stops
/// exactly at zero is then past the end, and the event finds it so. Above the rounding of 1 kV.
const OVERSHOOT: f64 = 1e-11;

impl DcLink {
    /// The time derivative of `s`, per s; mode and mean are copied from `s`.
    pub fn derivative(&self, s: &State, u: &Input) -> State {
        let i_load = u.load();
        let rates = self.rates(
            &Point::from_state(s),
            s.mode,
            i_load,
            &self.pack.line(s.soc),
        );
        State {
            soc: rates.soc,
            v: rates.v,
            v_c: rates.v_c,
            T: self.pack.temperature_rate(s.T, u.T_ambient, rates.heat),
            energy: Energies {
                battery: rates.battery,
                load: i_load * rates.flux,
                brake: rates.brake,
                loss: rates.loss,
            },
            ..*s
        }
    }

    /// Event indicators: the mode of `s` ends where one becomes positive. The first four are a
    /// current limit of the pack (A), a threshold of the chopper (V), that of precharge (V), and
    /// the capacitor empty (V) or no longer so (A); −1 for a guard that the mode does not have. The
    /// last two are the voltage above `v_min` and below `v_max`, V.
    pub fn mode_ends(&self, s: &State, u: &Input) -> [f64; ENDS] {
        let (v_min, v_max) = (self.p.v_min, self.p.v_max);
        let mut ends = [-1.0, -1.0, -1.0, -1.0, s.v_c - v_min, v_max - s.v_c];
        self.guards(&Point::from_state(s), s.mode, u.load(), |k, value| {
            ends[k] = value - OVERSHOOT
        });
        ends
    }

    /// `s` with the mode that holds from now on under the inputs `u`.
    pub fn with_current_mode(&self, s: &State, u: &Input) -> State {
        let mut x = Point::from_state(s);
        let mode = self.mode(&mut x, s.mode, u.load());
        State {
            v_c: x.v_c,
            v_mean: x.v_c,
            mode,
            ..*s
        }
    }
}
