//! Quantised position readings of the encoders of motors, joints and rods, for `sample`.

use crate::Encoder;

impl Encoder {
    /// Size of one count, where `whole` is a turn (or a metre).
    pub(crate) fn count(&self, whole: f64) -> f64 {
        whole * libm::exp2(-f64::from(self.bits))
    }

    /// Reading of a position: the nearest count, with `noise` in standard deviations.
    pub(crate) fn read(&self, position: f64, whole: f64, noise: f64) -> f64 {
        if !self.on {
            return position;
        }
        let count = self.count(whole);
        (position / count + self.noise * noise).round() * count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_reading_is_the_nearest_of_its_counts() {
        let encoder = Encoder {
            on: true,
            bits: 17,
            noise: 1.0,
        };
        let count = TAU / 131_072.0;
        for k in 0..1000 {
            let angle = 0.731 * f64::from(k) - 300.0;
            let read = encoder.read(angle, TAU, 0.0);
            assert!((read - angle).abs() <= 0.5 * count * (1.0 + 1e-9));
            let counts = read / count;
            assert!((counts - counts.round()).abs() < 1e-6, "{counts}");
        }
        let moved = encoder.read(1.0, TAU, 3.0) - encoder.read(1.0, TAU, 0.0);
        assert!((moved - 3.0 * count).abs() < 1e-12);
    }
}
