//! Sampled numbers for the report's sections and figures: single precision, little endian, base64.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::{Serialize, Serializer};

/// Time between two samples of most curves, s.
pub const EVERY: f64 = 0.02;

/// Values for plots and drawings; 24 bits are more than a screen shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples(Vec<f32>);

impl Samples {
    pub fn new(values: impl IntoIterator<Item = f64>) -> Self {
        Self(values.into_iter().map(|v| v as f32).collect())
    }

    /// Takes every `stride`-th value.
    pub fn thinned(values: &[f64], stride: usize) -> Self {
        Self::new(values.iter().step_by(stride).copied())
    }

    pub fn values(&self) -> impl Iterator<Item = f64> + Clone {
        self.0.iter().copied().map(f64::from)
    }
}

/// Times of evenly spaced samples.
#[derive(Serialize)]
pub struct SampleTimes {
    /// Time of the first, s.
    pub start: f64,
    /// Time between two, s.
    pub every: f64,
    pub count: usize,
}

/// Number of communication steps from one sample to the next.
pub fn stride(every: f64, step: f64) -> usize {
    ((every / step).round() as usize).max(1)
}

impl SampleTimes {
    /// Times of every `stride`-th of `count` points, which are `step` s apart.
    pub fn thinned(start: f64, step: f64, count: usize, stride: usize) -> Self {
        Self {
            start,
            every: stride as f64 * step,
            count: count.div_ceil(stride),
        }
    }

    /// Times, s, and values times `factor`.
    pub fn points(&self, samples: &Samples, factor: f64) -> Vec<(f64, f64)> {
        let time = |k: usize| self.start + k as f64 * self.every;
        let points = samples.values().enumerate();
        points.map(|(k, v)| (time(k), factor * v)).collect()
    }
}

impl Serialize for Samples {
    /// One value where all are the same, else all.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let same = self.0.windows(2).all(|pair| pair[0] == pair[1]);
        let count = if same { 1 } else { self.0.len() };
        let written = self.0.iter().take(count);
        let bytes: Vec<u8> = written.flat_map(|v| v.to_le_bytes()).collect();
        serializer.serialize_str(&STANDARD.encode(bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_little_endian_base64_and_constants_are_short() {
        let json = |v: &[f64]| serde_json::to_string(&Samples::new(v.iter().copied())).unwrap();
        // 1.0 = 0x3f800000, -2.0 = 0xc0000000 in IEEE 754.
        assert_eq!(json(&[1.0, -2.0]), "\"AACAPwAAAMA=\"");
        assert_eq!(json(&[1.0, 1.0, 1.0]), "\"AACAPw==\"");
        assert_eq!(json(&[]), "\"\"");
    }
}
