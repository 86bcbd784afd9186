//! Intervals over profiles: the bootstrap, and Clopper and Pearson's of a share.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Resamplings of the bootstrap.
const RESAMPLINGS: usize = 2000;

/// A statistic of `count` profiles and its 95 % interval, 2.5 and 97.5 % of the statistic on
/// resampled profiles (B. Efron, R. J. Tibshirani, *An Introduction to the Bootstrap*). `of` takes
/// the places of the profiles.
pub fn bootstrap(count: usize, of: impl Fn(&[usize]) -> f64) -> [f64; 3] {
    let all: Vec<usize> = (0..count).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut drawn = all.clone();
    let mut values: Vec<f64> = (0..RESAMPLINGS)
        .map(|_| {
            drawn.fill_with(|| rng.random_range(0..count));
            of(&drawn)
        })
        .collect();
    values.sort_unstable_by(f64::total_cmp);
    let at = |part: f64| values[(part * (RESAMPLINGS - 1) as f64).round() as usize];
    [of(&all), at(0.025), at(0.975)]
}

/// The 95 % interval of a share of which `count` of `of` were seen (Clopper and Pearson 1934): the
/// shares at which as many, or as few, come with 2.5 %.
pub fn binomial(count: usize, of: usize) -> [f64; 2] {
    let at_least = |share: f64| tail(count, of, share);
    let at_most = |share: f64| 1.0 - tail(count + 1, of, share);
    let rises = |f: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if f(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    [
        if count == 0 {
            0.0
        } else {
            rises(&|p| at_least(p) < 0.025)
        },
        if count == of {
            1.0
        } else {
            rises(&|p| at_most(p) > 0.025)
        },
    ]
}

/// Probability of `count` or more of `of` trials.
fn tail(count: usize, of: usize, share: f64) -> f64 {
    let (mut log, mut sum) = (of as f64 * (1.0 - share).ln(), 0.0);
    for k in 0..=of {
        if k >= count {
            sum += log.exp();
        }
        log += ((of - k) as f64 / (k + 1) as f64).ln() + (share / (1.0 - share)).ln();
    }
    sum
}
