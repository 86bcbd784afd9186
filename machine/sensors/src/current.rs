//! Current measurement of a motor, for `sample`: sensors in two phases with gain, offset, noise and
//! quantisation, transformed to dq coordinates with the measured angle.

use crate::Current;
use std::f64::consts::FRAC_PI_3;

/// Errors in the two phases of one motor: gain and offset relative to their bounds, noise in
/// standard deviations.
pub(crate) struct Errors {
    pub(crate) gain: [f64; 2],
    pub(crate) offset: [f64; 2],
    pub(crate) noise: [f64; 2],
}

impl Current {
    /// Readings `[i_d, i_q]` of a motor at angle `theta_m`, rad, whose encoder reads
    /// `theta_measured`. Phases a and b are measured, and transformed with the measured angle; the
    /// sum of all three is zero:
    /// ```text
    /// i_a = i_d cos θ_e − i_q sin θ_e,   i_b likewise at θ_e − 2π/3
    /// i_α = i_a,   i_β = (i_a + 2 i_b)/√3,   i_d = i_α cos θ_e + i_β sin θ_e,   i_q = i_β cos θ_e − i_α sin θ_e
    /// ```
    /// An offset becomes a ripple with the electrical frequency, a difference of the gains one with
    /// twice that frequency.
    pub(crate) fn read(
        &self,
        [i_d, i_q]: [f64; 2],
        theta_m: f64,
        theta_measured: f64,
        errors: &Errors,
    ) -> [f64; 2] {
        if !self.on {
            return [i_d, i_q];
        }
        let theta_e = f64::from(self.pole_pairs) * theta_m;
        let [i_a, i_b] = [0.0, 2.0 * FRAC_PI_3].map(|phase| {
            let (sin, cos) = libm::sincos(theta_e - phase);
            i_d * cos - i_q * sin
        });
        let i_a = self.convert(i_a, errors, 0);
        let i_b = self.convert(i_b, errors, 1);
        let i_beta = (i_a + 2.0 * i_b) / 3.0_f64.sqrt();
        let (sin, cos) = libm::sincos(f64::from(self.pole_pairs) * theta_measured);
        [i_a * cos + i_beta * sin, i_beta * cos - i_a * sin]
    }

    /// Reading of the current in a phase, quantised and saturated by the converter.
    fn convert(&self, i: f64, errors: &Errors, phase: usize) -> f64 {
        let i = (1.0 + self.gain * errors.gain[phase]) * i
            + self.offset * errors.offset[phase]
            + self.noise * errors.noise[phase];
        let largest = libm::exp2(f64::from(self.bits));
        let count = 2.0 * self.range / largest;
        (i / count).round().max(-0.5 * largest).min(0.5 * largest) * count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Current = Current {
        on: true,
        gain: 0.0,
        offset: 0.0,
        noise: 0.0,
        bits: 40,
        range: 150.0,
        pole_pairs: 4,
    };
    const NONE: Errors = Errors {
        gain: [0.0; 2],
        offset: [0.0; 2],
        noise: [0.0; 2],
    };

    /// Into the phases and back with the same angle is the identity; 40 bits of 300 A leave 1.4e-10
    /// A in each phase.
    #[test]
    fn phases_and_back_is_the_same_current() {
        for k in 0..100 {
            let theta = 0.37 * f64::from(k) - 11.0;
            let [d, q] = PLAIN.read([-3.1, 27.3], theta, theta, &NONE);
            assert!((d + 3.1).abs() < 1e-9 && (q - 27.3).abs() < 1e-9, "{d} {q}");
        }
    }

    /// Oracle by hand. With θ_e = 0 phase a lies on the d axis: its offset o appears as i_d = o
    /// and, since c = −a − b, as i_q = o/√3; phase b's offset as i_q = 2 o/√3. An angle read δ too
    /// large turns the current back by p·δ.
    #[test]
    fn offsets_and_angle_errors_come_out_as_by_hand() {
        let sensor = Current {
            offset: 0.1,
            ..PLAIN
        };
        let errors = |offset| Errors { offset, ..NONE };
        let root = 3.0_f64.sqrt();
        let near =
            |[d, q]: [f64; 2], [e, f]: [f64; 2]| (d - e).abs() < 1e-9 && (q - f).abs() < 1e-9;
        let found = sensor.read([0.0; 2], 0.0, 0.0, &errors([1.0, 0.0]));
        assert!(near(found, [0.1, 0.1 / root]), "{found:?}");
        let found = sensor.read([0.0; 2], 0.0, 0.0, &errors([0.0, 1.0]));
        assert!(near(found, [0.0, 0.2 / root]), "{found:?}");
        let found = PLAIN.read([0.0, 10.0], 0.3, 0.3 + 0.01, &NONE);
        let (sin, cos) = 0.04_f64.sin_cos();
        assert!(near(found, [10.0 * sin, 10.0 * cos]), "{found:?}");
    }

    /// Twelve bits over ±150 A: the currents at θ_e = 0 lie on the lattice of 300/4096 A, and
    /// saturate at 150 A.
    #[test]
    fn the_converter_rounds_and_saturates() {
        let sensor = Current { bits: 12, ..PLAIN };
        let [d, _] = sensor.read([17.77, 0.0], 0.0, 0.0, &NONE);
        let count = 300.0 / 4096.0;
        assert!((d - (17.77_f64 / count).round() * count).abs() < 1e-12);
        assert!(sensor.read([400.0, 0.0], 0.0, 0.0, &NONE)[0] == 150.0);
    }
}
