//! [`Algorithm`]: the interface of the methods to the solver's fixed and adaptive internal steps.

use super::system::System;

/// An internal step, which the methods read and fill in. Vectors have an element for each state.
pub(crate) struct Step {
    /// Time of the start of the communication step, s.
    pub(crate) t: f64,
    /// Start of the internal step, from `t` on, and its length, s.
    pub(crate) s: f64,
    pub(crate) dt: f64,
    /// Magnitudes of the states.
    pub(crate) nominal: Vec<f64>,
    /// States at the start and the end.
    pub(crate) x: Vec<f64>,
    pub(crate) end: Vec<f64>,
    /// The estimated errors, later the states at an event in the step.
    pub(crate) error: Vec<f64>,
    /// The vectors a, b and c of the states within the step, `x(θ) = x₀ + θ (Δ + (1 − θ) (a + θ (b
    /// + θ c)))`, θ from 0 to 1; empty if there are no events to locate.
    pub(crate) dense: [Vec<f64>; 3],
}

/// A one-step method.
pub(crate) trait Algorithm {
    /// Whether [`begin`](Self::begin) evaluates a Jacobian.
    const HAS_JACOBIAN: bool = false;

    /// Prepares for steps from a point and returns the rates there. Called once for each point: the
    /// start of the communication step (`s` = 0), and the end of each accepted step. `dt` is the
    /// approximate length of the step.
    fn begin<S: System>(&mut self, system: &mut S, step: &Step) -> Result<&[f64], S::Error>;

    /// Computes one step: the states at its end, and the estimate of their errors. Returns false if
    /// its linear equations have no solution.
    fn step<S: System>(&mut self, system: &mut S, step: &mut Step) -> Result<bool, S::Error>;

    /// The same, without further evaluations and perhaps less exact, to look for events.
    fn rough_output<S: System>(&mut self, system: &mut S, step: &mut Step) -> Result<(), S::Error> {
        self.dense_output(system, step)
    }

    /// The interpolation of the states within the last step.
    fn dense_output<S: System>(&mut self, system: &mut S, step: &mut Step) -> Result<(), S::Error>;
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
