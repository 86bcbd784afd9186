//! What the methods have in common.

use super::dense_output::DenseOutput;
use super::system::System;

/// A one-step method. States and rates are slices of one length; `s` and `dt` are where an internal
/// step begins and how long it is, s.
pub(crate) trait Algorithm {
    /// Whether [`begin`](Self::begin) evaluates a Jacobian.
    const HAS_JACOBIAN: bool = false;

    /// What is needed at a point where steps will be tried, once for each: at the start of a
    /// communication step (`s` = 0), then at the end of each step that is taken. The answer is the
    /// rates there. `dt` is about the length of the step, `nominal` the size of the states.
    fn begin<S: System>(
        &mut self,
        system: &mut S,
        point: (f64, f64, f64),
        x: &[f64],
        nominal: &[f64],
    ) -> Result<&[f64], S::Error>;

    /// A trial of one step: states at its end, and the estimate of their errors. False if its
    /// equations have no solution.
    fn step<S: System>(
        &mut self,
        system: &mut S,
        step: (f64, f64),
        x: &[f64],
        end: &mut [f64],
        error: &mut [f64],
    ) -> Result<bool, S::Error>;

    /// The states within the step that was tried last, between those at its `ends`.
    fn dense_output<S: System>(
        &mut self,
        system: &mut S,
        step: (f64, f64),
        ends: [&[f64]; 2],
        to: &mut DenseOutput,
    ) -> Result<(), S::Error>;
}

/// So many vectors of `n` zeros.
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
