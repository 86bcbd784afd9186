//! Random numbers for `sensors` and `sample`: constant errors of a run, and noise of each sample.

use crate::{ACTUATORS, JOINTS, normal};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Stream of the seed's generator for noise.
const NOISE: u64 = 0;
/// Stream for the constant errors.
const ERRORS: u64 = 1;

fn generator(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(stream);
    generator
}

/// Constant errors of a run relative to their bounds: uniform between −1 and 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedErrors {
    /// Zeros of the joints.
    pub zero: [f64; JOINTS],
    /// Gains of the current sensors in two phases of each motor.
    pub gain: [[f64; 2]; ACTUATORS],
    /// Offsets of the current sensors.
    pub offset: [[f64; 2]; ACTUATORS],
    /// Biases of the force sensors.
    pub bias: [f64; ACTUATORS],
    /// Gains of the force sensors.
    pub force_gain: [f64; ACTUATORS],
}

impl FixedErrors {
    pub(crate) fn from_seed(seed: u64) -> Self {
        let mut generator = generator(seed, ERRORS);
        let mut part = || generator.random_range(-1.0..=1.0);
        Self {
            zero: std::array::from_fn(|_| part()),
            gain: std::array::from_fn(|_| [part(), part()]),
            offset: std::array::from_fn(|_| [part(), part()]),
            bias: std::array::from_fn(|_| part()),
            force_gain: std::array::from_fn(|_| part()),
        }
    }
}

/// Noise of one sample, in standard deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Motor encoders.
    pub motor: [f64; ACTUATORS],
    /// Joint encoders.
    pub joint: [f64; JOINTS],
    /// Rod encoders.
    pub rod: [f64; ACTUATORS],
    /// Currents in two phases of each motor.
    pub current: [[f64; 2]; ACTUATORS],
    /// Forces.
    pub force: [f64; ACTUATORS],
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Source(ChaCha8Rng);

impl Source {
    pub(crate) fn new(seed: u64) -> Self {
        Self(generator(seed, NOISE))
    }

    pub(crate) fn next(&mut self) -> Noise {
        let mut normal = || normal::draw(&mut self.0);
        Noise {
            motor: std::array::from_fn(|_| normal()),
            joint: std::array::from_fn(|_| normal()),
            rod: std::array::from_fn(|_| normal()),
            current: std::array::from_fn(|_| [normal(), normal()]),
            force: std::array::from_fn(|_| normal()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean, variance and neighbours of 20000 samples of every channel. Tolerances: four standard
    /// deviations of these estimates, 1/√n for the mean and the product, √(2/n) for the variance.
    #[test]
    fn noise_is_white_with_variance_one() {
        const N: usize = 20_000;
        let mut source = Source::new(5);
        let samples: Vec<Noise> = (0..N).map(|_| source.next()).collect();
        let channels: [fn(&Noise) -> f64; 6] = [
            |n| n.motor[0],
            |n| n.joint[5],
            |n| n.rod[2],
            |n| n.current[1][0],
            |n| n.current[1][1],
            |n| n.force[2],
        ];
        for (k, of) in channels.iter().enumerate() {
            let mean = |f: &dyn Fn(usize) -> f64| (1..N).map(f).sum::<f64>() / (N - 1) as f64;
            let bound = 4.0 / (N as f64).sqrt();
            let average = mean(&|i| of(&samples[i]));
            let variance = mean(&|i| of(&samples[i]).powi(2));
            let neighbours = mean(&|i| of(&samples[i]) * of(&samples[i - 1]));
            assert!(average.abs() < bound, "{k}: mean {average}");
            assert!((variance - 1.0).abs() < 1.5 * bound, "{k}: {variance}");
            assert!(neighbours.abs() < bound, "{k}: {neighbours}");
        }
    }

    #[test]
    fn errors_lie_within_their_bounds_and_differ_by_seed() {
        let (a, b) = (FixedErrors::from_seed(1), FixedErrors::from_seed(2));
        assert_eq!(a, FixedErrors::from_seed(1));
        assert_ne!(a, b);
        let all = |d: &FixedErrors| {
            let phases = [d.gain, d.offset].concat().concat();
            [&d.zero[..], &d.bias[..], &d.force_gain[..], &phases[..]].concat()
        };
        assert!((0..200).all(|seed| {
            all(&FixedErrors::from_seed(seed))
                .iter()
                .all(|e| e.abs() <= 1.0)
        }));
        assert!((0..200).any(|seed| {
            all(&FixedErrors::from_seed(seed))
                .iter()
                .any(|e| e.abs() > 0.99)
        }));
    }
}
