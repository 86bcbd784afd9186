//! Temperatures of winding and housing and their effects, for `step`, `continuous` and `output`.
//!
//! Source: F. P. Incropera et al., *Fundamentals of Heat and Mass Transfer*, lumped capacitance.

use crate::actuator::Emla;
use crate::state::{State, Thermal};
use machine_file::{Heat, Temperature};
use std::borrow::Cow;

/// Longest Runge–Kutta step over the faster time constant; the error of `e^z` is z⁵/120.
const SHARE: f64 = 0.02;
const MAX_STEPS: f64 = 1e6;

impl Emla {
    pub(crate) fn heat(&self) -> Heat {
        self.p.heat.unwrap_or(Heat::TYPICAL)
    }

    pub(crate) fn temperature(&self) -> Temperature {
        self.p.temperature.unwrap_or(Temperature::TYPICAL)
    }

    /// The parameters at these temperatures: `R_s·(1 + α_Cu·(T_w − T_ref))`,
    /// `λ_m·(1 + α_m·(T_h − T_ref))`.
    pub(crate) fn at_temperature(&self, now: &Thermal) -> Cow<'_, machine_file::Emla> {
        if !self.electric.temperature {
            return Cow::Borrowed(&self.p);
        }
        let t = self.temperature();
        Cow::Owned(machine_file::Emla {
            R_s: self.p.R_s * (1.0 + t.copper * (now.T_winding - t.reference)),
            lambda_m: self.p.lambda_m * (1.0 + t.magnet * (now.T_housing - t.reference)),
            ..self.p
        })
    }

    /// Derivatives of resistance and flux for the derivatives `change` of the temperatures.
    pub(crate) fn temperature_tangent(&self, change: &Thermal) -> (f64, f64) {
        if !self.electric.temperature {
            return (0.0, 0.0);
        }
        let t = self.temperature();
        let copper = self.p.R_s * t.copper * change.T_winding;
        (copper, self.p.lambda_m * t.magnet * change.T_housing)
    }

    /// Rates of the temperatures, K/s, and the heat given to the air, W:
    /// ```text
    /// C_w Ṫ_w = P_copper − (T_w − T_h)/R_wh
    /// C_h Ṫ_h = P_core + P_mech + (T_w − T_h)/R_wh − (T_h − T_a)/R_ha
    /// ```
    pub(crate) fn temperature_rates(
        &self,
        now: &Thermal,
        T_ambient: f64,
        copper: f64,
        other: f64,
    ) -> Thermal {
        let h = self.heat();
        let inner = (now.T_winding - now.T_housing) / h.R_wh;
        let given = (now.T_housing - T_ambient) / h.R_ha;
        Thermal {
            T_winding: (copper - inner) / h.C_w,
            T_housing: (other + inner - given) / h.C_h,
            given,
        }
    }

    /// Heat flow to the air at these temperatures, W; 0 if heat is not modelled.
    pub(crate) fn heat_flow(&self, now: &Thermal, T_ambient: f64) -> f64 {
        if self.electric.heat {
            (now.T_housing - T_ambient) / self.heat().R_ha
        } else {
            0.0
        }
    }

    /// Heat stored in winding and housing above the reference temperature, J.
    pub(crate) fn heat_held(&self, now: &Thermal) -> f64 {
        let zero = self.temperature().reference;
        self.heat_rise(now.T_winding - zero, now.T_housing - zero)
    }

    /// Heat for these temperature rises of winding and housing, K, in J.
    pub(crate) fn heat_rise(&self, winding: f64, housing: f64) -> f64 {
        let h = self.heat();
        h.C_w * winding + h.C_h * housing
    }

    /// The temperatures after a step of `h` s from `start` to `end` with its mean losses; None if
    /// the step is too long for the time constants. `R_s(T)` and `λ_m(T)` are held over the step, a
    /// first-order error (h/2 late), 1e-8 of the temperature rise at 1 ms.
    pub(crate) fn temperatures_after(
        &self,
        start: &State,
        end: &State,
        T_ambient: f64,
        h: f64,
    ) -> Option<Thermal> {
        let copper = end.kinds.copper - start.kinds.copper;
        let inverter = end.kinds.inverter - start.kinds.inverter;
        let other = end.energy.lost - start.energy.lost - copper - inverter;
        let p = self.heat();
        let fastest = 1.0 / (p.C_w * p.R_wh) + (1.0 / p.R_wh + 1.0 / p.R_ha) / p.C_h;
        let n = (h * fastest / SHARE).ceil().max(1.0);
        if n > MAX_STEPS {
            return None;
        }
        let dt = h / n;
        let rates = |now: &Thermal| self.temperature_rates(now, T_ambient, copper / h, other / h);
        let mut now = start.thermal;
        for _ in 0..n as u32 {
            let a = rates(&now);
            let b = rates(&now.plus(0.5 * dt, &a));
            let c = rates(&now.plus(0.5 * dt, &b));
            let d = rates(&now.plus(dt, &c));
            for (weight, rate) in [(1.0, a), (2.0, b), (2.0, c), (1.0, d)] {
                now = now.plus(weight / 6.0 * dt, &rate);
            }
        }
        Some(now)
    }
}

impl Thermal {
    fn plus(&self, dt: f64, rate: &Self) -> Self {
        Self {
            T_winding: self.T_winding + dt * rate.T_winding,
            T_housing: self.T_housing + dt * rate.T_housing,
            given: self.given + dt * rate.given,
        }
    }
}
