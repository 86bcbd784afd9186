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

/// How far a straight line between two samples that a page keeps may be from one that is left out.
#[derive(Clone, Copy)]
pub enum Tolerance {
    /// In the signal's unit.
    Absolute(f64),
    /// This part of the sample itself, for a logarithmic axis.
    Relative(f64),
    /// This part of the signal's range.
    OfRange(f64),
}

impl Samples {
    /// The samples that a page needs, as base64: `n` values, then as bytes the `n - 1` distances in
    /// samples from one to the next. Straight lines between them keep to `tolerance`; single
    /// precision adds its rounding.
    pub fn sparse(&self, tolerance: Tolerance) -> String {
        let values: Vec<f64> = self.values().collect();
        let ends = |(low, high): (f64, f64), v: &f64| (low.min(*v), high.max(*v));
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), ends);
        let within = |v: f64| match tolerance {
            Tolerance::Absolute(most) => most,
            Tolerance::Relative(part) => part * v.abs(),
            Tolerance::OfRange(part) => part * (high - low),
        };
        let mut kept = Vec::from_iter((!values.is_empty()).then_some(0));
        // Slopes from the last kept sample that pass all samples since within the tolerance.
        let mut slopes = [f64::NEG_INFINITY, f64::INFINITY];
        for k in 1..values.len() {
            let mut from = kept[kept.len() - 1];
            let slope = |from: usize, v: f64| (v - values[from]) / (k - from) as f64;
            let passes = |at: f64, [least, most]: [f64; 2]| least <= at && at <= most;
            if !passes(slope(from, values[k]), slopes) || k - from > usize::from(u8::MAX) {
                from = k - 1;
                kept.push(from);
                slopes = [f64::NEG_INFINITY, f64::INFINITY];
            }
            let most = within(values[k]);
            slopes = [
                slopes[0].max(slope(from, values[k] - most)),
                slopes[1].min(slope(from, values[k] + most)),
            ];
        }
        // A signal that never changes is one value.
        if high > low {
            kept.push(values.len() - 1);
        } else {
            kept.truncate(1);
        }
        kept.dedup();
        let numbers = kept.iter().flat_map(|k| self.0[*k].to_le_bytes());
        let gaps = kept.windows(2).map(|pair| (pair[1] - pair[0]) as u8);
        STANDARD.encode(numbers.chain(gaps).collect::<Vec<_>>())
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

    /// What the page does with it, in another way: values by linear interpolation between the kept.
    #[test]
    fn sparse_samples_keep_to_their_tolerance() {
        let wave = |k: usize| (0.013 * k as f64).sin() * (-0.001 * k as f64).exp();
        let steps = |k: usize| f64::from(k % 700 > 350) + wave(k);
        for (signal, tolerance) in [
            (Samples::new((0..3000).map(wave)), Tolerance::OfRange(5e-4)),
            (
                Samples::new((0..3000).map(steps)),
                Tolerance::Absolute(1e-3),
            ),
            (
                Samples::new((0..3000).map(|k| 2.0 + wave(k))),
                Tolerance::Relative(0.01),
            ),
        ] {
            let bytes = STANDARD.decode(signal.sparse(tolerance)).unwrap();
            let n = bytes.len().div_ceil(5);
            assert!(n < 400, "{n} of 3000 are kept");
            let value = |j: usize| f32::from_le_bytes(bytes[4 * j..4 * j + 4].try_into().unwrap());
            let all: Vec<f64> = signal.values().collect();
            let (mut k, mut worst) = (0, 0.0_f64);
            for j in 1..n {
                let gap = usize::from(bytes[4 * n + j - 1]);
                for i in 0..=gap {
                    let part = i as f64 / gap as f64;
                    let line = (1.0 - part) * f64::from(value(j - 1)) + part * f64::from(value(j));
                    let most = match tolerance {
                        Tolerance::Absolute(most) => most,
                        Tolerance::Relative(relative) => relative * all[k + i].abs(),
                        // The wave's range is that of its first period: from its largest to its least.
                        Tolerance::OfRange(part) => part * 1.6,
                    };
                    worst = worst.max((line - all[k + i]).abs() / most);
                }
                k += gap;
            }
            assert_eq!(k, all.len() - 1, "the last one is kept");
            assert!(
                worst < 1.0 + 1e-3 && worst > 0.5,
                "{worst} of the tolerance"
            );
        }
        assert_eq!(
            Samples::new([1.0; 300]).sparse(Tolerance::OfRange(1e-3)),
            "AACAPw=="
        );
        assert_eq!(Samples::new([]).sparse(Tolerance::OfRange(1e-3)), "");
    }

    #[test]
    fn samples_are_little_endian_base64_and_constants_are_short() {
        let json = |v: &[f64]| serde_json::to_string(&Samples::new(v.iter().copied())).unwrap();
        // 1.0 = 0x3f800000, -2.0 = 0xc0000000 in IEEE 754.
        assert_eq!(json(&[1.0, -2.0]), "\"AACAPwAAAMA=\"");
        assert_eq!(json(&[1.0, 1.0, 1.0]), "\"AACAPw==\"");
        assert_eq!(json(&[]), "\"\"");
    }
}
