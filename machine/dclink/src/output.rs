//! The start state of the DC link, and its outputs, for the FMU `DcLink`.

use crate::circuit::Point;
use crate::input::Input;
use crate::link::DcLink;
use crate::state::{Energies, Mode, Regime, State};

/// Outputs of the link; see also the FMU's variable descriptions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Voltage of the capacitor, V.
    pub v_dc: f64,
    /// Its mean over the last step, V.
    pub v_dc_mean: f64,
    /// Current of the pack, A.
    pub i_battery: f64,
    /// Voltage at the pack's terminals, V.
    pub v_battery: f64,
    /// State of charge.
    pub soc: f64,
    /// Power burnt in the brake resistor, W.
    pub P_brake: f64,
    /// Power lost in all but the brake resistor, W.
    pub P_loss: f64,
    /// Temperature of the pack, K.
    pub T_battery: f64,
    /// Energies since the start.
    pub energy: Energies,
    /// Energy in the capacitor and the RC pairs, J.
    pub stored: f64,
    /// Voltages of the RC pairs, V.
    pub v_pairs: [f64; 2],
    /// Whether precharge is over.
    pub ready: bool,
    /// Whether precharge is still going on.
    pub precharging: bool,
    /// Whether the brake resistor is switched on.
    pub braking: bool,
    /// Whether the pack's current is at its limit.
    pub limited: bool,
    /// Whether precharge is over and the voltage is below `v_min`.
    pub undervoltage: bool,
}

impl DcLink {
    /// The start state: the pack at rest, and the capacitor at the pack's voltage or, with
    /// precharge, at `precharge.v_start`.
    pub fn start(&self, u: &Input) -> State {
        let (b, precharge) = (&self.p.battery, &self.p.precharge);
        let open = self.pack.open_circuit(b.soc_start);
        let v_c = if precharge.on {
            precharge.v_start
        } else {
            open
        };
        let mut x = Point {
            soc: b.soc_start,
            v_c,
            ..Point::default()
        };
        let ready = Mode {
            ready: !precharge.on,
            ..Mode::default()
        };
        let mode = self.mode(&mut x, ready, u.load());
        State {
            soc: x.soc,
            v: x.v,
            v_c: x.v_c,
            T: b.T_start,
            mode,
            energy: Energies::default(),
            v_mean: x.v_c,
        }
    }

    /// Outputs of a state; no input has direct feedthrough.
    pub fn output(&self, s: &State) -> Output {
        let flow = self.flow(&Point::from_state(s), s.mode, &self.pack.line(s.soc));
        let stored = 0.5 * self.p.link.C * s.v_c * s.v_c + self.pack.pair_energy(s.v);
        Output {
            v_dc: s.v_c,
            v_dc_mean: s.v_mean,
            i_battery: flow.i,
            v_battery: flow.v_oc - s.v[0] - s.v[1] - self.p.battery.R_0 * flow.i,
            soc: s.soc,
            P_brake: flow.P_brake,
            P_loss: flow.P_loss,
            T_battery: s.T,
            energy: s.energy,
            stored,
            v_pairs: s.v,
            ready: s.mode.ready,
            precharging: !s.mode.ready,
            braking: s.mode.braking,
            limited: s.mode.regime != Regime::Free,
            undervoltage: s.mode.ready && s.v_c < self.p.v_min,
        }
    }
}
