//! Temperatures of an actuator whose motion is repeated for hours: two nodes, winding and housing,
//! fed by the losses of one cycle.
#![allow(non_snake_case)] // symbols of the equations

use serde::Serialize;

/// Temperature coefficient of copper's resistance, 1/K, at [`REFERENCE`].
const COPPER: f64 = 0.00393;
/// Temperature at which resistances are given, K.
const REFERENCE: f64 = 293.15;

/// The two nodes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Network {
    /// Heat capacity of the winding, J/K.
    pub winding: f64,
    /// Heat resistance from winding to housing, K/W.
    pub inside: f64,
    /// Heat capacity of the housing, J/K.
    pub housing: f64,
    /// Heat resistance from the housing to the air, K/W.
    pub outside: f64,
    /// Temperature of the air, K.
    pub ambient: f64,
}

/// Losses of one cycle at equal steps of time.
pub struct Cycle<'a> {
    /// Time between two values, s.
    pub step: f64,
    /// Losses in the winding, W.
    pub copper: &'a [f64],
    /// Temperatures of the winding at which they arose, K; empty: the reference temperature.
    pub winding: &'a [f64],
    /// Losses in the iron, W: they warm the housing.
    pub iron: &'a [f64],
}

/// What becomes of the temperatures, K.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Temperatures {
    /// Greatest temperature of the winding.
    pub winding_max: f64,
    /// Temperature of the winding at the end.
    pub winding: f64,
    /// Temperature of the housing at the end.
    pub housing: f64,
}

impl Network {
    /// Typical of a motor of 10 kW with convection, where the actuator tells of no heat.
    pub const TYPICAL: Self = Self {
        winding: 2e3,
        inside: 0.06,
        housing: 15e3,
        outside: 0.15,
        ambient: REFERENCE,
    };

    /// Rates of the temperatures `[winding, housing]`, K/s, with losses of `copper` and `iron`, W.
    fn rates(&self, [T_w, T_h]: [f64; 2], copper: f64, iron: f64) -> [f64; 2] {
        let inside = (T_w - T_h) / self.inside;
        let outside = (T_h - self.ambient) / self.outside;
        [
            (copper - inside) / self.winding,
            (inside + iron - outside) / self.housing,
        ]
    }

    /// Temperatures after `duration`, s, of the cycle repeated, from the ambient temperature on.
    /// The resistance of the copper follows the winding; Heun's method at the cycle's own steps,
    /// which are a ten-thousandth of the time constants.
    pub fn after(&self, cycle: &Cycle, duration: f64) -> Temperatures {
        let mut T = [self.ambient; 2];
        let mut found = Temperatures {
            winding_max: self.ambient,
            winding: self.ambient,
            housing: self.ambient,
        };
        if cycle.copper.is_empty() {
            return found;
        }
        let hot = |T_w: f64| 1.0 + COPPER * (T_w - REFERENCE);
        let steps = (duration / cycle.step) as u64;
        for (k, _) in (0..cycle.copper.len()).cycle().zip(0..steps) {
            let arose = cycle.winding.get(k).copied().unwrap_or(REFERENCE);
            let rates = |T: [f64; 2]| {
                let copper = cycle.copper[k] * hot(T[0]) / hot(arose);
                self.rates(T, copper, cycle.iron[k])
            };
            let h = cycle.step;
            let first = rates(T);
            let then = rates([T[0] + h * first[0], T[1] + h * first[1]]);
            T = [0, 1].map(|n| T[n] + 0.5 * h * (first[n] + then[n]));
            found.winding_max = found.winding_max.max(T[0]);
        }
        (found.winding, found.housing) = (T[0], T[1]);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At rest: T_h = T_a + R_ha (P_cu + P_fe), T_w = T_h + R_wh P_cu with P_cu = P (1 + a (T_w −
    /// T_ref)), a linear equation in T_w. After 40 time constants of the housing (2250 s) e⁻⁴⁰ is
    /// left of the way there.
    #[test]
    fn a_constant_loss_ends_at_the_equilibrium() {
        let n = Network::TYPICAL;
        let (P, iron) = (280.0, 35.0);
        let cycle = Cycle {
            step: 0.5,
            copper: &[P, P],
            winding: &[],
            iron: &[iron, iron],
        };
        let found = n.after(&cycle, 90_000.0);
        let both = n.inside + n.outside;
        let excess = (both * P + n.outside * iron) / (1.0 - both * P * COPPER);
        let copper = P * (1.0 + COPPER * excess);
        let housing = n.ambient + n.outside * (copper + iron);
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
        let closed = Network {
            outside: 1e12,
            inside: 1e-3,
            ..Network::TYPICAL
        };
        let cycle = Cycle {
            step: 1e-3,
            copper: &[200.0, 0.0],
            winding: &[REFERENCE; 2],
            iron: &[0.0, 0.0],
        };
        let found = closed.after(&cycle, 20.0);
        let stored = 2e3 * (found.winding - REFERENCE) + 15e3 * (found.housing - REFERENCE);
        // 100 W on average, and a few thousandths more as the copper warms by 0.1 K.
        assert!((stored / 2000.0 - 1.0).abs() < 1e-3, "{stored} J");
    }
}
