//! The battery pack's equations, for `circuit` and `step`: open-circuit voltage, current limits, RC
//! pairs, temperature. Divisors are stored as their inverses.

use crate::params::{Battery, POINTS};
use serde::{Deserialize, Serialize};

/// Resistance, Ω, up to which an RC pair is left out: 1000 A would drop a microvolt across it, and
/// its inverse must stay finite.
const NO_PAIR: f64 = 1e-9;

/// A pack with its constants computed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pack {
    b: Battery,
    /// Open-circuit voltage of the pack at the left ends of the table's pieces, V, and its rise
    /// over each of them, V.
    open: [[f64; 2]; POINTS - 1],
    /// Change of the state of charge per charge taken, 1/(A·s).
    soc_per_charge: f64,
    /// 1/τ of the RC pairs, 1/s.
    rate: [f64; 2],
    /// 1/R of the RC pairs, S; 0 where there is none.
    conductance: [f64; 2],
    /// Inverse heat capacity, K/J, and inverse thermal resistance, W/K.
    heat: [f64; 2],
}

impl Pack {
    /// From checked parameters.
    pub fn new(b: &Battery) -> Self {
        let cells = f64::from(b.cells);
        Self {
            b: *b,
            open: std::array::from_fn(|k| [cells * b.ocv[k], cells * (b.ocv[k + 1] - b.ocv[k])]),
            soc_per_charge: 1.0 / (3600.0 * b.capacity),
            rate: b.tau.map(|tau| 1.0 / tau),
            conductance: b.R.map(|R| if R > NO_PAIR { 1.0 / R } else { 0.0 }),
            heat: [1.0 / b.heat_capacity, 1.0 / b.heat_resistance],
        }
    }

    /// Open-circuit voltage, V: linear between the points, extrapolated beyond the ends.
    pub fn open_circuit(&self, soc: f64) -> f64 {
        self.line(soc).at(soc)
    }

    /// The linear piece of the open-circuit voltage at this charge.
    pub(crate) fn line(&self, soc: f64) -> Line {
        let pieces = (POINTS - 1) as f64;
        // Truncation takes negative numbers and NaN to 0.
        let k = ((soc * pieces) as usize).min(POINTS - 2);
        let [left, rise] = self.open[k];
        Line {
            left,
            from: k as f64 / pieces,
            slope: rise * pieces,
        }
    }

    /// Largest discharge and charge current at this state of charge, A, both ≥ 0.
    pub fn limits(&self, soc: f64) -> (f64, f64) {
        let b = &self.b;
        let part = |left: f64, width: f64| {
            if left >= width {
                1.0
            } else {
                (left / width).max(0.0)
            }
        };
        (
            b.discharge_limit * part(soc, b.soc_low),
            b.charge_limit * part(1.0 - soc, 1.0 - b.soc_high),
        )
    }

    /// Rate of the state of charge at the current `i`, 1/s.
    pub fn soc_rate(&self, i: f64) -> f64 {
        -i * self.soc_per_charge
    }

    /// Rates of the RC pairs' voltages `v` at the current `i`, V/s: `τ dv/dt = R i − v`.
    pub fn pair_rates(&self, v: [f64; 2], i: f64) -> [f64; 2] {
        [0, 1].map(|k| (self.b.R[k] * i - v[k]) * self.rate[k])
    }

    /// Power lost in the resistances of the RC pairs, W: `v²/R`.
    pub fn pair_losses(&self, v: [f64; 2]) -> f64 {
        let [G_1, G_2] = self.conductance;
        v[0] * v[0] * G_1 + v[1] * v[1] * G_2
    }

    /// Energy in the capacitors of the RC pairs, J: `½ (τ/R) v²`.
    pub fn pair_energy(&self, v: [f64; 2]) -> f64 {
        let energy = |k: usize| 0.5 * self.b.tau[k] * self.conductance[k] * v[k] * v[k];
        energy(0) + energy(1)
    }

    /// The temperature a time `h` after `T`, K, with the heat `E`, J, generated at a constant rate:
    /// `T + (1 − e^−x)·(E/(G h) − (T − T_a))` with `x = G h/C`, the exact solution.
    pub fn temperature_after(&self, T: f64, T_ambient: f64, E: f64, h: f64) -> f64 {
        let [per_capacity, G] = self.heat;
        let x = G * h * per_capacity;
        // (1 − e^−x)/x; the series' next term is x⁴/120.
        let share = if x < 1e-3 {
            1.0 - x * (1.0 / 2.0 - x * (1.0 / 6.0 - x / 24.0))
        } else {
            -libm::expm1(-x) / x
        };
        T + share * per_capacity * (E - G * h * (T - T_ambient))
    }

    /// Rate of the temperature `T`, K/s, with the heat `P`, W, generated: `(P − G·(T − T_a))/C`.
    pub fn temperature_rate(&self, T: f64, T_ambient: f64, P: f64) -> f64 {
        let [per_capacity, G] = self.heat;
        per_capacity * (P - G * (T - T_ambient))
    }
}

/// A linear piece of the open-circuit voltage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Voltage at the charge `from`, V.
    left: f64,
    from: f64,
    /// Rise per charge, V.
    slope: f64,
}

impl Line {
    /// Voltage at this charge, V.
    pub(crate) fn at(&self, soc: f64) -> f64 {
        self.left + self.slope * (soc - self.from)
    }
}
