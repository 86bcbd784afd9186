//! Sensor noise: seeded Gaussian numbers added to chosen inputs whenever they are passed; off
//! unless asked for.

use anyhow::{Result, ensure};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// White noise on an input of one component.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Component whose input is disturbed; other components that get the same signal do not see the
    /// noise.
    pub component: String,
    /// Input, or the name of an array of inputs without its index.
    pub variable: String,
    /// Standard deviation, in the input's unit; each communication point draws anew.
    pub sigma: f64,
}

/// Noise on measurements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Noise {
    /// Disturbed inputs; none: no noise.
    pub sensors: Vec<Sensor>,
    /// Seed of the generator: equal seeds give equal runs.
    pub seed: u64,
}

impl Noise {
    /// Refuse deviations that are none.
    pub fn check(&self) -> Result<()> {
        for s in &self.sensors {
            ensure!(
                s.sigma.is_finite() && s.sigma >= 0.0,
                "noise of {}.{}: the standard deviation {} must be finite and not negative",
                s.component,
                s.variable,
                s.sigma
            );
        }
        Ok(())
    }

    /// Standard deviation on an input; 0 where none is asked for.
    pub fn sigma(&self, component: &str, variable: &str) -> f64 {
        let fits = |s: &&Sensor| s.component == component && is_element(&s.variable, variable);
        self.sensors.iter().rfind(fits).map_or(0.0, |s| s.sigma)
    }
}

/// True where `variable` is `name` or an element of the array `name`.
pub fn is_element(name: &str, variable: &str) -> bool {
    let rest = variable.strip_prefix(name);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
}

/// The generator of a run.
#[derive(Debug)]
pub struct Source(ChaCha8Rng);

impl Source {
    /// A generator with this seed.
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Add to each value noise of its standard deviation.
    pub fn disturb(&mut self, values: &mut [f64], sigma: &[f64]) {
        for (value, sigma) in values.iter_mut().zip(sigma) {
            let normal: f64 = StandardNormal.sample(&mut self.0);
            *value += sigma * normal;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_is_named_without_its_index_and_the_last_word_counts() {
        let sensor = |variable: &str, sigma| Sensor {
            component: "c".into(),
            variable: variable.into(),
            sigma,
        };
        let noise = Noise {
            sensors: vec![sensor("zeta", 1.0), sensor("zeta[2]", 3.0)],
            seed: 1,
        };
        assert_eq!(noise.sigma("c", "zeta[1]"), 1.0);
        assert_eq!(noise.sigma("c", "zeta[2]"), 3.0);
        assert_eq!(noise.sigma("c", "zeta_dot[1]"), 0.0);
        assert_eq!(noise.sigma("d", "zeta[1]"), 0.0);
        let bad = Noise {
            sensors: vec![sensor("zeta", -1.0)],
            seed: 1,
        };
        assert!(noise.check().is_ok() && bad.check().is_err());
    }

    /// Mean and deviation of n draws: within 4 of their own standard errors, σ/√n and σ/√(2n).
    #[test]
    fn the_noise_has_the_deviation_asked_for_and_repeats_with_its_seed() {
        let (n, sigma) = (40_000_u32, 0.25);
        let mut values = vec![3.0; n as usize];
        Source::new(7).disturb(&mut values, &vec![sigma; n as usize]);
        let n = f64::from(n);
        let mean = values.iter().sum::<f64>() / n;
        let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!((mean - 3.0).abs() < 4.0 * sigma / n.sqrt(), "{mean}");
        assert!(
            (spread - sigma).abs() < 4.0 * sigma / (2.0 * n).sqrt(),
            "{spread}"
        );
        let mut again = vec![3.0; values.len()];
        Source::new(7).disturb(&mut again, &vec![sigma; values.len()]);
        assert_eq!(values, again);
    }
}
