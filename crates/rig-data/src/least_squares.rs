//! Nonlinear least squares of a few parameters, with intervals that know that rows of one profile
//! are no independent rows.

use std::ops::Range;

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
    /// are the rows of each profile.
    ///
    /// The intervals are those of Liang and Zeger (1986, *Longitudinal data analysis using
    /// generalized linear models*), `V = A⁻¹ Σ_g (J_gᵀ e_g)(J_gᵀ e_g)ᵀ A⁻¹ · G/(G − 1)`, `A = JᵀJ`,
    /// over the G profiles g: what errs alike in a profile, as its sensors do, counts once.
    ///
    /// # Panics
    /// Rows that do not determine the parameters.
    #[must_use]
    pub fn new(
        first: [f64; N],
        sizes: [f64; N],
        profiles: &[Range<usize>],
        of: impl Fn(&[f64; N], usize) -> f64,
    ) -> Self {
        let rows = || profiles.iter().cloned().flatten();
        let square = |at: &[f64; N]| rows().map(|row| of(at, row).powi(2)).sum::<f64>();
        let slopes = |at: &[f64; N], row: usize| -> [f64; N] {
            std::array::from_fn(|k| {
                let moved = |by: f64| {
                    let mut other = *at;
                    other[k] += by * 1e-4 * sizes[k];
                    of(&other, row)
                };
                (moved(1.0) - moved(-1.0)) / 2e-4
            })
        };
        let (mut values, mut mu) = (first, 1e-3);
        let mut least = square(&values);
        for _ in 0..STEPS {
            let (mut A, mut g) = ([[0.0; N]; N], [0.0; N]);
            for row in rows() {
                let (j, e) = (slopes(&values, row), of(&values, row));
                for a in 0..N {
                    g[a] += j[a] * e;
                    for b in 0..N {
                        A[a][b] += j[a] * j[b];
                    }
                }
            }
            let mut damped = A;
            for (k, row) in damped.iter_mut().enumerate() {
                row[k] *= 1.0 + mu;
            }
            let step = solve(damped, g);
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
        let (mut A, mut middle, mut count) = ([[0.0; N]; N], [[0.0; N]; N], 0.0);
        for profile in profiles {
            let mut score = [0.0; N];
            for row in profile.clone() {
                let (j, e) = (slopes(&values, row), of(&values, row));
                count += 1.0;
                for a in 0..N {
                    score[a] += j[a] * e;
                    for b in 0..N {
                        A[a][b] += j[a] * j[b];
                    }
                }
            }
            for a in 0..N {
                for b in 0..N {
                    middle[a][b] += score[a] * score[b];
                }
            }
        }
        let groups = profiles.len() as f64;
        let half = std::array::from_fn(|k| {
            let unit = std::array::from_fn(|j| f64::from(u8::from(j == k)));
            let column = solve(A, unit);
            let all = (0..N).flat_map(|a| (0..N).map(move |b| (a, b)));
            let variance: f64 = all.map(|(a, b)| column[a] * middle[a][b] * column[b]).sum();
            NORMAL_95 * sizes[k] * (variance * groups / (groups - 1.0)).sqrt()
        });
        Self {
            values,
            half,
            rms: (least / count).sqrt(),
        }
    }
}

/// Gauss's elimination with the largest pivot of each column.
fn solve<const N: usize>(mut A: [[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    for k in 0..N {
        let by_size = |&i: &usize, &j: &usize| A[i][k].abs().total_cmp(&A[j][k].abs());
        let pivot = (k..N).max_by(by_size).expect("at least one row");
        A.swap(k, pivot);
        b.swap(k, pivot);
        assert!(A[k][k] != 0.0, "the rows determine the parameters");
        for i in k + 1..N {
            let share = A[i][k] / A[k][k];
            let above = A[k];
            for (cell, from) in A[i].iter_mut().zip(above) {
                *cell -= share * from;
            }
            b[i] -= share * b[k];
        }
    }
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| A[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / A[k][k];
    }
    b
}
