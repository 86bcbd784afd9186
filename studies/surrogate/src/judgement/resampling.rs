//! 95 % confidence intervals, by the bootstrap and by Clopper and Pearson; also for `experiments`.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const RESAMPLINGS: usize = 2000;

/// A statistic of `count` profiles and its 95 % interval, between the 2.5 and 97.5 % quantiles of
/// the statistic on resampled profiles (B. Efron, R. J. Tibshirani, *An Introduction to the
/// Bootstrap*). `statistic` takes the profiles' indices.
pub fn bootstrap(count: usize, statistic: impl Fn(&[usize]) -> f64) -> [f64; 3] {
    let all: Vec<usize> = (0..count).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut drawn = all.clone();
    let mut values: Vec<f64> = (0..RESAMPLINGS)
        .map(|_| {
            drawn.fill_with(|| rng.random_range(0..count));
            statistic(&drawn)
        })
        .collect();
    values.sort_unstable_by(f64::total_cmp);
    let quantile = |part: f64| values[(part * (RESAMPLINGS - 1) as f64).round() as usize];
    [statistic(&all), quantile(0.025), quantile(0.975)]
}

/// The 95 % interval of a probability when `count` of `total` trials succeeded (Clopper and Pearson
/// 1934): its ends are the probabilities at which as many successes, or as few, have 2.5 %.
pub fn binomial(count: usize, total: usize) -> [f64; 2] {
    let at_least = |share: f64| tail(count, total, share);
    let at_most = |share: f64| 1.0 - tail(count + 1, total, share);
    let bisect = |f: &dyn Fn(f64) -> bool| {
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
        match count {
            0 => 0.0,
            _ => bisect(&|p| at_least(p) < 0.025),
        },
        match total - count {
            0 => 1.0,
            _ => bisect(&|p| at_most(p) > 0.025),
        },
    ]
}

/// Probability that at least `count` of `total` trials succeed.
fn tail(count: usize, total: usize, share: f64) -> f64 {
    let (mut log, mut sum) = (total as f64 * (1.0 - share).ln(), 0.0);
    for k in 0..=total {
        if k >= count {
            sum += log.exp();
        }
        log += ((total - k) as f64 / (k + 1) as f64).ln() + (share / (1.0 - share)).ln();
    }
    sum
}
