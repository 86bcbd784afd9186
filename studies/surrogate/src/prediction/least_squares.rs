//! Nonlinear least squares of a few parameters, with intervals that know that rows of one profile
//! are no independent rows.

use nalgebra::{Cholesky, Const, SMatrix, SVector};

/// Steps at most; well-posed fits need fewer than ten.
const STEPS: u32 = 100;
/// Half the width of a 95 % interval over the standard error.
const NORMAL_95: f64 = 1.959_964;

/// Fitted parameters.
#[derive(Clone, Copy, Debug)]
pub struct Fit<const N: usize> {
    /// Least squares.
    pub values: [f64; N],
    /// Half the widths of the 95 % intervals.
    pub half: [f64; N],
    /// Root mean square of the residuals.
    pub rms: f64,
}

impl<const N: usize> Fit<N> {
    /// Levenberg and Marquardt's least squares of the residuals `of(parameters, row)` from `first`
    /// on; derivatives are central differences over `sizes`, of the parameters' order. `profiles`
    /// has the rows of each profile.
    ///
    /// The intervals are those of Liang and Zeger (1986, *Longitudinal data analysis using
    /// generalized linear models*), `V = A⁻¹ Σ_g (J_gᵀ e_g)(J_gᵀ e_g)ᵀ A⁻¹ · G/(G − 1)`, `A = JᵀJ`,
    /// over the G profiles g: what errs alike in a profile, as its sensors do, counts once.
    ///
    /// # Panics
    /// Rows that do not determine the parameters.
    pub fn new<R>(
        first: [f64; N],
        sizes: [f64; N],
        profiles: &[Vec<R>],
        of: impl Fn(&[f64; N], &R) -> f64,
    ) -> Self {
        let square = |at: &[f64; N]| {
            let rows = profiles.iter().flatten();
            rows.map(|row| of(at, row).powi(2)).sum::<f64>()
        };
        let slopes = |at: &[f64; N], row: &R| {
            SVector::<f64, N>::from_fn(|k, _| {
                let moved = |by: f64| {
                    let mut other = *at;
                    other[k] += by * 1e-4 * sizes[k];
                    of(&other, row)
                };
                (moved(1.0) - moved(-1.0)) / 2e-4
            })
        };
        // A, and J_gᵀ e_g of each profile.
        let normal = |at: &[f64; N]| {
            let (mut A, mut scores) = (SMatrix::<f64, N, N>::zeros(), Vec::new());
            for profile in profiles {
                let mut score = SVector::<f64, N>::zeros();
                for row in profile {
                    let j = slopes(at, row);
                    score += j * of(at, row);
                    A += j * j.transpose();
                }
                scores.push(score);
            }
            (A, scores)
        };
        let (mut values, mut mu) = (first, 1e-3);
        let mut least = square(&values);
        for _ in 0..STEPS {
            let (mut damped, scores) = normal(&values);
            for k in 0..N {
                damped[(k, k)] *= 1.0 + mu;
            }
            let step = factored(damped).solve(&scores.iter().sum());
            let trial = std::array::from_fn(|k| values[k] - sizes[k] * step[k]);
            let tried = square(&trial);
            // Scaled steps far below the intervals end the search, better or not.
            let done = step.iter().all(|s| s.abs() < 1e-10);
            if tried < least {
                (values, least, mu) = (trial, tried, mu * 0.1);
            } else {
                mu *= 10.0;
            }
            if done {
                break;
            }
        }
        let (A, scores) = normal(&values);
        let inverse = factored(A).inverse();
        let middle: SMatrix<f64, N, N> = scores.iter().map(|s| s * s.transpose()).sum();
        let groups = profiles.len() as f64;
        let variance = inverse * middle * inverse * (groups / (groups - 1.0));
        let count: usize = profiles.iter().map(Vec::len).sum();
        Self {
            values,
            half: std::array::from_fn(|k| NORMAL_95 * sizes[k] * variance[(k, k)].sqrt()),
            rms: (least / count as f64).sqrt(),
        }
    }
}

fn factored<const N: usize>(A: SMatrix<f64, N, N>) -> Cholesky<f64, Const<N>> {
    A.cholesky().expect("the rows determine the parameters")
}
