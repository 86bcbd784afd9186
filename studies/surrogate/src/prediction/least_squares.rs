//! Nonlinear least squares of a few parameters, with confidence intervals that account for the
//! dependence between rows of one profile; `identification` calls it.

use nalgebra::{Cholesky, Const, SMatrix, SVector};

/// Largest number of steps; well-posed fits need fewer than ten.
const STEPS: u32 = 100;
/// Half the width of a 95 % interval over the standard error.
const NORMAL_95: f64 = 1.959_964;

/// Fitted parameters.
#[derive(Clone, Copy, Debug)]
pub struct Fit<const N: usize> {
    /// The parameters.
    pub values: [f64; N],
    /// Half the widths of their 95 % intervals.
    pub half: [f64; N],
    /// Root mean square of the residuals.
    pub rms: f64,
}

impl<const N: usize> Fit<N> {
    /// Minimises the sum of the squared residuals `residual(parameters, row)` by Levenberg and
    /// Marquardt's method from `first`. `sizes` are the parameters' orders of magnitude: the search
    /// works in parameters divided by them, with central differences of 1e-4 of each. `profiles`
    /// holds the rows of each profile.
    ///
    /// The intervals are those of Liang and Zeger (1986, *Longitudinal data analysis using
    /// generalized linear models*), `V = A⁻¹ Σ_g (J_gᵀ e_g)(J_gᵀ e_g)ᵀ A⁻¹ · G/(G − 1)`, `A = JᵀJ`,
    /// over the G profiles g: an error common to a profile, as a sensor's offset is, counts once.
    /// Panics if the rows do not determine the parameters.
    pub fn new<R>(
        first: [f64; N],
        sizes: [f64; N],
        profiles: &[Vec<R>],
        residual: impl Fn(&[f64; N], &R) -> f64,
    ) -> Self {
        let square = |at: &[f64; N]| {
            let rows = profiles.iter().flatten();
            rows.map(|row| residual(at, row).powi(2)).sum::<f64>()
        };
        let slopes = |at: &[f64; N], row: &R| {
            SVector::<f64, N>::from_fn(|k, _| {
                let moved = |by: f64| {
                    let mut other = *at;
                    other[k] += by * 1e-4 * sizes[k];
                    residual(&other, row)
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
                    score += j * residual(at, row);
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
            let stepped = std::array::from_fn(|k| values[k] - sizes[k] * step[k]);
            let sum = square(&stepped);
            // Scaled steps far below the intervals end the search, better or not.
            let done = step.iter().all(|s| s.abs() < 1e-10);
            if sum < least {
                (values, least, mu) = (stepped, sum, mu * 0.1);
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
