//! One Levenberg–Marquardt iteration as MATLAB's `trainlm` takes it; `progress` makes one an epoch.
//!
//! The error is the mean over all R residuals, `mse = Σ e²/R`, `e = y − target`. A step solves
//! `(JᵀJ/R + mu·I)·dw = −Jᵀe/R`. If it lowers the error it is taken and `mu` falls to a tenth;
//! otherwise `mu` grows tenfold and the step is solved again, until `mu` exceeds its limit.

use std::collections::BTreeMap;

use crate::training::network::Shape;
use crate::training::normal::{Form, TiledMatrix, residual_order};

/// First `mu` of a training.
pub const MU_START: f64 = 1e-3;
const MU_DECREASE: f64 = 0.1;
const MU_INCREASE: f64 = 10.0;
pub(crate) const MU_MAX: f64 = 1e10;
/// Norm of the error's gradient below which the training ends.
pub(crate) const GRADIENT_MIN: f64 = 1e-7;

/// Scaled inputs and targets.
#[derive(Clone, Debug)]
pub struct Samples {
    /// One row per sample.
    pub inputs: Vec<[f64; 2]>,
    /// One row per sample.
    pub targets: Vec<[f64; 2]>,
}

impl Samples {
    /// Means of the samples in each of `cells` × `cells` cells of the inputs' range [−1, 1], in the
    /// order of the cells.
    pub fn cell_means(&self, cells: u32) -> Self {
        let cell = |x: f64| (0.5 * (x + 1.0) * f64::from(cells)) as u32;
        let mut sums: BTreeMap<[u32; 2], ([f64; 4], f64)> = BTreeMap::new();
        for (x, y) in self.inputs.iter().zip(&self.targets) {
            let (sum, count) = sums.entry(x.map(cell)).or_default();
            for (sum, value) in sum.iter_mut().zip([x[0], x[1], y[0], y[1]]) {
                *sum += value;
            }
            *count += 1.0;
        }
        let means = || sums.values().map(|(sum, count)| sum.map(|s| s / count));
        Self {
            inputs: means().map(|m| [m[0], m[1]]).collect(),
            targets: means().map(|m| [m[2], m[3]]).collect(),
        }
    }

    /// `y − target`.
    pub fn residuals(&self, shape: &Shape, weights: &[f64]) -> Vec<[f64; 2]> {
        let y = shape.evaluate(weights, &self.inputs);
        y.iter()
            .zip(&self.targets)
            .map(|(y, t)| [y[0] - t[0], y[1] - t[1]])
            .collect()
    }

    /// Mean of the squared residuals of both outputs.
    pub fn mse(&self, shape: &Shape, weights: &[f64]) -> f64 {
        mean_square(&self.residuals(shape, weights))
    }
}

fn mean_square(e: &[[f64; 2]]) -> f64 {
    e.iter().map(|e| e[0] * e[0] + e[1] * e[1]).sum::<f64>() / (2 * e.len()) as f64
}

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The error decreased.
    Stepped,
    /// The gradient is below `GRADIENT_MIN`; nothing changed.
    FlatGradient,
    /// No step lowered the error before `mu` passed `MU_MAX`; nothing changed.
    MuMax,
}

/// Takes one iteration; changes `weights` and `mu`.
pub fn iterate(shape: &Shape, samples: &Samples, weights: &mut Vec<f64>, mu: &mut f64) -> Outcome {
    let form = Form::cheaper(shape, samples.inputs.len());
    iterate_in(form, shape, samples, weights, mu)
}

/// [`iterate`] with a chosen form of the normal matrix.
pub fn iterate_in(
    form: Form,
    shape: &Shape,
    samples: &Samples,
    weights: &mut Vec<f64>,
    mu: &mut f64,
) -> Outcome {
    let e = samples.residuals(shape, weights);
    let count = (2 * e.len()) as f64;
    let before = mean_square(&e);
    let views = shape.views(weights, &samples.inputs);
    let gradient = shape.jacobian_transposed_times(&views, &e);
    let norm = gradient.iter().map(|g| g * g).sum::<f64>().sqrt() * 2.0 / count;
    if norm < GRADIENT_MIN {
        return Outcome::FlatGradient;
    }
    let normal = match form {
        Form::Weights => TiledMatrix::weights(shape, &views, e.len()),
        Form::Residuals => TiledMatrix::residuals(shape, &views, e.len()),
    };
    let order = residual_order(shape, e.len());
    while *mu <= MU_MAX {
        let mut factor = normal.clone();
        if factor.factor(*mu * count).is_ok() {
            let step = match form {
                Form::Weights => {
                    let mut x = gradient.clone();
                    factor.solve(&mut x);
                    x
                }
                Form::Residuals => {
                    let mut x: Vec<f64> = order.iter().map(|&(n, o)| e[n][o]).collect();
                    factor.solve(&mut x);
                    let mut weighted = vec![[0.0; 2]; e.len()];
                    for (&(n, o), x) in order.iter().zip(x) {
                        weighted[n][o] = x;
                    }
                    shape.jacobian_transposed_times(&views, &weighted)
                }
            };
            let stepped: Vec<f64> = weights.iter().zip(&step).map(|(w, s)| w - s).collect();
            if samples.mse(shape, &stepped) < before {
                *weights = stepped;
                *mu *= MU_DECREASE;
                return Outcome::Stepped;
            }
        }
        *mu *= MU_INCREASE;
    }
    Outcome::MuMax
}
