//! Rod forces.

use crate::{Force, ForceKind};
use std::f64::consts::TAU;

impl Force {
    /// State of the lag after the force `F`, N, that comes `period` s after the last one, exact for
    /// a force held since:
    /// ```text
    /// y ← y + (1 − e^(−2π f_c T))·(F − y)
    /// ```
    pub(crate) fn lag(&self, before: f64, F: f64, period: Option<f64>) -> f64 {
        match (self.kind, period) {
            (ForceKind::Sensor, Some(T)) => {
                before - libm::expm1(-TAU * self.bandwidth * T) * (F - before)
            }
            _ => F,
        }
    }

    /// Reading, N: of the lag's state and what errs (`bias` a part of the bound, `noise` in
    /// standard deviations), or of the measured quadrature current `i_q`, A, where there is no
    /// sensor.
    pub(crate) fn read(&self, lagged: f64, bias: f64, noise: f64, i_q: f64) -> f64 {
        match self.kind {
            ForceKind::Ideal => lagged,
            ForceKind::Sensor => lagged + self.bias * bias + self.noise * noise,
            ForceKind::Absent => self.per_current * i_q,
        }
    }
}
