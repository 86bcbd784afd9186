//! State of the DC link, which the FMU saves: charge, voltages, temperature, mode, energies.

use model_rules::{StepError, check_finite};
use serde::{Deserialize, Serialize};

/// What sets the current of the pack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Regime {
    /// The circuit: voltage difference over resistance.
    #[default]
    Free,
    /// The discharge limit.
    Discharging,
    /// The charge limit.
    Charging,
}

/// The circuit's discrete state between two events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// What sets the current of the pack.
    pub regime: Regime,
    /// Whether precharge is over.
    pub ready: bool,
    /// Whether the brake resistor is switched on.
    pub braking: bool,
    /// Whether the capacitor is empty while the drives draw more than the pack delivers: the diodes
    /// of their inverters then carry the rest, at zero voltage.
    pub empty: bool,
}

/// State of the link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// State of charge.
    pub soc: f64,
    /// Voltages of the RC pairs, V.
    pub v: [f64; 2],
    /// Voltage of the capacitor, V.
    pub v_c: f64,
    /// Temperature of the pack, K.
    pub T: f64,
    /// Discrete state of the circuit.
    pub mode: Mode,
    /// Energies since the start.
    pub energy: Energies,
    /// Mean of the capacitor's voltage over the last step, V.
    pub v_mean: f64,
}

/// Energies since the start, J: `battery = load + brake + loss + rise of the stored energy`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// From the source of the pack: open-circuit voltage times current.
    pub battery: f64,
    /// To the drives.
    pub load: f64,
    /// Burnt in the brake resistor.
    pub brake: f64,
    /// Lost in the pack, in the wiring, in precharge and in the limit.
    pub loss: f64,
}

impl State {
    /// Checks that all values are finite; `t`, s, is the time in the error message.
    pub(crate) fn check_finite(&self, t: f64) -> Result<(), StepError> {
        let values = [
            ("soc", self.soc),
            ("v_1", self.v[0]),
            ("v_2", self.v[1]),
            ("v_dc", self.v_c),
            ("T_battery", self.T),
            ("energy.battery", self.energy.battery),
            ("energy.load", self.energy.load),
            ("energy.brake", self.energy.brake),
            ("energy.loss", self.energy.loss),
        ];
        check_finite(t, values)
    }
}
