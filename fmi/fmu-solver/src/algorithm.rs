//! [`Algorithm`]: the interface of the methods to the solver's fixed and adaptive internal steps.

use super::dense_output::DenseOutput;
use super::system::System;

/// A one-step method. States and rates are slices of the same length; `s` and `dt` are start and
/// length of an internal step, s.
pub(crate) trait Algorithm {
    /// Whether [`begin`](Self::begin) evaluates a Jacobian.
    const HAS_JACOBIAN: bool = false;

    /// Prepares for steps from a `point` (`t`, `s`, `dt`) and returns the rates there. Called once
    /// for each point: the start of the communication step (`s` = 0), and the end of each accepted
    /// step. `dt` is the approximate length of the step, `nominal` the magnitude of the states.
    fn begin<S: System>(
        &mut self,
        system: &mut S,
        point: (f64, f64, f64),
        x: &[f64],
        nominal: &[f64],
    ) -> Result<&[f64], S::Error>;

    /// Computes one step: the states at its end, and the estimate of their errors. Returns false if
    /// its linear equations have no solution.
    fn step<S: System>(
        &mut self,
        system: &mut S,
        step: (f64, f64),
        x: &[f64],
        end: &mut [f64],
        error: &mut [f64],
    ) -> Result<bool, S::Error>;

    /// The interpolation of the states within the last step, between those at its `ends`.
    fn dense_output<S: System>(
        &mut self,
        system: &mut S,
        step: (f64, f64),
        ends: [&[f64]; 2],
        to: &mut DenseOutput,
    ) -> Result<(), S::Error>;
}

/// `N` vectors of `n` zeros.
pub(crate) fn vectors<const N: usize>(n: usize) -> [Vec<f64>; N] {
    std::array::from_fn(|_| vec![0.0; n])
}

/// Adds Σ `weights` · `vectors` to `to`.
pub(crate) fn add(to: &mut [f64], weights: impl IntoIterator<Item = f64>, vectors: &[Vec<f64>]) {
    for (weight, vector) in weights.into_iter().zip(vectors) {
        for (to, value) in to.iter_mut().zip(vector) {
            *to += weight * value;
        }
    }
}
