//! Readings of rod forces, for `sample`: a load cell with lag, hysteresis, gain error, bias and
//! noise, or an estimate from the motor current.

use crate::{Force, ForceKind};
use std::f64::consts::TAU;

impl Force {
    /// State of the first-order lag at the sample `F`, N, `period` s after the last one, exact for
    /// a force held since then:
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

    /// Output of the cell's hysteresis for the force `F`, N, and its previous output `before`: it
    /// follows once the force has changed by half the width w, the play operator
    /// ```text
    /// y ← min(max(y, F − w/2), F + w/2)
    /// ```
    /// (I. D. Mayergoyz, *Mathematical Models of Hysteresis*). Without a width it is `F`.
    pub(crate) fn hysteresis(&self, before: f64, F: f64, is_first: bool) -> f64 {
        if self.kind != ForceKind::Sensor || self.hysteresis == 0.0 || is_first {
            return F;
        }
        let half = 0.5 * self.hysteresis;
        before.max(F - half).min(F + half)
    }

    /// Reading, N, from the hysteresis output `shown` and the errors (`gain` and `bias` relative to
    /// their bounds, `noise` in standard deviations), or from the measured quadrature current
    /// `i_q`, A, without a sensor.
    pub(crate) fn read(&self, shown: f64, [gain, bias]: [f64; 2], noise: f64, i_q: f64) -> f64 {
        match self.kind {
            ForceKind::Ideal => shown,
            ForceKind::Sensor => {
                shown * (1.0 + self.gain * gain) + self.bias * bias + self.noise * noise
            }
            ForceKind::Absent => self.per_current * i_q,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Params;

    fn cell(hysteresis: f64) -> Force {
        Force {
            kind: ForceKind::Sensor,
            hysteresis,
            gain: 0.01,
            ..Params::OFF.force
        }
    }

    /// A force that goes up and down between ±A is shown behind by half the width w on either way:
    /// a parallelogram of width w and height 2A − w. Trapezoids over steps of A/1000 miss less than
    /// a step times the width.
    #[test]
    fn a_cycle_of_force_encloses_the_loop_of_its_width() {
        let (w, A) = (210.0, 31e3);
        let cell = cell(w);
        let force = |k: i32| {
            let part = f64::from(k % 4000) / 1000.0;
            A * if part < 2.0 { part - 1.0 } else { 3.0 - part }
        };
        let (mut y, mut area, mut widest) = (cell.hysteresis(0.0, force(0), true), 0.0, 0.0_f64);
        for k in 1..=8000 {
            let next = cell.hysteresis(y, force(k), false);
            if k > 4000 {
                area += 0.5 * (next + y) * (force(k) - force(k - 1));
            }
            widest = widest.max((next - force(k)).abs());
            y = next;
        }
        assert!((widest - 0.5 * w).abs() < 1e-9, "{widest}");
        assert!(
            (area.abs() - w * (2.0 * A - w)).abs() < w * A / 1000.0,
            "{area}"
        );
    }

    #[test]
    fn the_gain_errs_by_its_part_of_the_bound() {
        let reading = cell(0.0).read(40e3, [-0.5, 0.2], 0.0, 0.0);
        assert!(
            (reading - (40e3 * 0.995 + 0.2 * 350.0)).abs() < 1e-9,
            "{reading}"
        );
    }
}
