//! Temperatures of winding and housing, two lumped thermal masses, for `dynamics` and `output`.
//!
//! Source: F. P. Incropera et al., *Fundamentals of Heat and Mass Transfer*, lumped capacitance.

use crate::Rig;

/// Temperature rates and heat flow at an instant.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ThermalRates {
    /// Rate of the winding's temperature, K/s.
    pub T_winding: f64,
    /// Rate of the housing's temperature, K/s.
    pub T_housing: f64,
    /// Heat flow to the air, W.
    pub given: f64,
}

impl Rig {
    /// Copper losses heat the winding; iron losses and friction heat the housing, which is cooled
    /// by the air. The inverter has its own cooling.
    /// ```text
    /// C_w Ṫ_w = P_copper − (T_w − T_h)/R_wh
    /// C_h Ṫ_h = P_iron + P_friction + (T_w − T_h)/R_wh − (T_h − T_a)/R_ha
    /// ```
    pub(crate) fn temperature_rates(
        &self,
        T: [f64; 2],
        T_ambient: f64,
        copper: f64,
        other: f64,
    ) -> ThermalRates {
        let h = &self.extra.heat;
        if !h.on {
            return ThermalRates::default();
        }
        let [T_w, T_h] = T;
        let inner = (T_w - T_h) / h.R_wh;
        let given = (T_h - T_ambient) / h.R_ha;
        ThermalRates {
            T_winding: (copper - inner) / h.C_w,
            T_housing: (other + inner - given) / h.C_h,
            given,
        }
    }

    /// Heat stored at these temperatures above the reference temperature, J.
    pub(crate) fn heat_held(&self, T: [f64; 2]) -> f64 {
        let (h, zero) = (&self.extra.heat, self.extra.temperature.reference);
        h.C_w * (T[0] - zero) + h.C_h * (T[1] - zero)
    }
}

#[cfg(test)]
mod tests {
    use crate::Rig;

    /// 316 W of copper, the loss at rated torque, settle at 316·(0.06 + 0.15) = 66.4 K above the
    /// air.
    #[test]
    fn rated_copper_losses_settle_at_66_kelvin() {
        let rig = Rig::as_built();
        let air = 293.15;
        let settled = [air + 316.0 * 0.21, air + 316.0 * 0.15];
        let now = rig.temperature_rates(settled, air, 316.0, 0.0);
        assert!(now.T_winding.abs() < 1e-12 && now.T_housing.abs() < 1e-12);
        assert!((now.given - 316.0).abs() < 1e-9);
        let cold = rig.temperature_rates([air; 2], air, 316.0, 100.0);
        assert!((cold.T_winding - 0.158).abs() < 1e-12);
        assert!((cold.T_housing - 100.0 / 15e3).abs() < 1e-12);
    }
}
