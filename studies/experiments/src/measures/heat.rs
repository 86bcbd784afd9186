//! Temperatures of an actuator whose motion is repeated for hours, for the sizing study: a thermal
//! network of two nodes, winding and housing, heated by the losses of one cycle.
#![allow(non_snake_case)] // symbols of the equations

use machine_file::{Heat, Temperature};
use serde::Serialize;

/// The thermal network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatNetwork {
    /// Capacities and resistances.
    pub heat: Heat,
    /// Temperature of the air, K.
    pub ambient: f64,
}

/// Losses of one cycle at equal steps of time.
pub struct Cycle<'a> {
    /// Time between two values, s.
    pub step: f64,
    /// Losses in the winding, W.
    pub copper: &'a [f64],
    /// Temperatures of the winding at these losses, K; empty: the reference temperature.
    pub winding: &'a [f64],
    /// Losses in the iron, W; they heat the housing.
    pub iron: &'a [f64],
}

/// Temperatures after repeated cycles, K.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Temperatures {
    /// Greatest temperature of the winding.
    pub winding_max: f64,
    /// Temperature of the winding at the end.
    pub winding: f64,
    /// Temperature of the housing at the end.
    pub housing: f64,
}

impl HeatNetwork {
    /// For actuators without outputs or parameters of heat.
    pub const TYPICAL: Self = Self {
        heat: Heat::TYPICAL,
        ambient: Temperature::TYPICAL.reference,
    };

    /// Rates of the temperatures `[winding, housing]`, K/s, with losses of `copper` and `iron`, W.
    fn rates(&self, [T_w, T_h]: [f64; 2], copper: f64, iron: f64) -> [f64; 2] {
        let p = &self.heat;
        let inside = (T_w - T_h) / p.R_wh;
        let outside = (T_h - self.ambient) / p.R_ha;
        [(copper - inside) / p.C_w, (inside + iron - outside) / p.C_h]
    }

    /// Temperatures after the cycle has been repeated for `duration`, s, starting at the ambient
    /// temperature. The copper's resistance follows the winding temperature. Heun's method at the
    /// cycle's own steps, which are a ten-thousandth of the time constants.
    pub fn temperatures_after(&self, cycle: &Cycle, duration: f64) -> Temperatures {
        let mut T = [self.ambient; 2];
        let mut winding_max = self.ambient;
        let p = Temperature::TYPICAL;
        let hot = |T_w: f64| 1.0 + p.copper * (T_w - p.reference);
        // An empty cycle leaves the ambient temperature.
        let steps = (duration / cycle.step) as u64;
        for (k, _) in (0..cycle.copper.len()).cycle().zip(0..steps) {
            let arose = cycle.winding.get(k).copied().unwrap_or(p.reference);
            let rates = |T: [f64; 2]| {
                let copper = cycle.copper[k] * hot(T[0]) / hot(arose);
                self.rates(T, copper, cycle.iron[k])
            };
            let h = cycle.step;
            let first = rates(T);
            let then = rates([T[0] + h * first[0], T[1] + h * first[1]]);
            T = [0, 1].map(|n| T[n] + 0.5 * h * (first[n] + then[n]));
            winding_max = winding_max.max(T[0]);
        }
        let [winding, housing] = T;
        Temperatures {
            winding_max,
            winding,
            housing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Copper's rise of resistance, 1/K, from this temperature on, K.
    const COPPER: f64 = 0.00393;
    const REFERENCE: f64 = 293.15;

    /// At rest: T_h = T_a + R_ha (P_cu + P_fe), T_w = T_h + R_wh P_cu with P_cu = P (1 + a (T_w −
    /// T_ref)), a linear equation in T_w. After 40 time constants of the housing (2250 s) e⁻⁴⁰ is
    /// left of the way there.
    #[test]
    fn a_constant_loss_ends_at_the_equilibrium() {
        let n = HeatNetwork::TYPICAL;
        let (P, iron) = (280.0, 35.0);
        let cycle = Cycle {
            step: 0.5,
            copper: &[P, P],
            winding: &[],
            iron: &[iron, iron],
        };
        let found = n.temperatures_after(&cycle, 90_000.0);
        let (outside, both) = (n.heat.R_ha, n.heat.R_wh + n.heat.R_ha);
        let excess = (both * P + outside * iron) / (1.0 - both * P * COPPER);
        let copper = P * (1.0 + COPPER * excess);
        let housing = n.ambient + outside * (copper + iron);
        assert!(
            (found.winding - n.ambient - excess).abs() < 1e-9,
            "{found:?}"
        );
        assert!((found.housing - housing).abs() < 1e-9, "{found:?}");
    }

    /// Without a way out and with a run that was as hot as the motor gets here, both nodes store
    /// all of the loss.
    #[test]
    fn what_does_not_leave_stays() {
        let heat = Heat {
            R_ha: 1e12,
            R_wh: 1e-3,
            ..Heat::TYPICAL
        };
        let closed = HeatNetwork {
            heat,
            ..HeatNetwork::TYPICAL
        };
        let cycle = Cycle {
            step: 1e-3,
            copper: &[200.0, 0.0],
            winding: &[REFERENCE; 2],
            iron: &[0.0, 0.0],
        };
        let found = closed.temperatures_after(&cycle, 20.0);
        let stored = 2e3 * (found.winding - REFERENCE) + 15e3 * (found.housing - REFERENCE);
        // 100 W on average, and a few thousandths more as the copper warms by 0.1 K.
        assert!((stored / 2000.0 - 1.0).abs() < 1e-3, "{stored} J");
    }
}
