//! What a solver of the layer keeps from one step of a model to the next.

use super::log::Log;
use fmu_solver::{Solver, TOLERANCE};

/// What a solver keeps from one step to the next, of a model `M` with inputs `U`.
pub struct SolverWorkspace<M, U> {
    /// The internal step to try first, s; 0: not known. The rest has no memory of its own.
    pub(crate) first: f64,
    /// The tolerance of an internal step.
    pub(crate) tolerance: f64,
    /// What solvers tell.
    pub(crate) log: Log,
    pub(super) scratch: Option<Box<Scratch<M, U>>>,
}

impl<M, U> SolverWorkspace<M, U> {
    /// Makes the scratch anew, for vectors of another length.
    pub(crate) fn invalidate(&mut self) {
        self.scratch = None;
    }
}

#[cfg_attr(
    not(feature = "derive"),
    expect(dead_code, reason = "what is derived alone is solved by the layer")
)]
pub(super) struct Scratch<M, U> {
    pub(super) solver: Solver,
    /// The model on its way through the step.
    pub(super) at: M,
    /// A copy of the model whose states are derivatives.
    pub(super) rate: M,
    /// A direction of states and inputs, of which the latter is zero, if the model has derivatives
    /// along it.
    pub(super) direction: Option<(M, U)>,
    pub(super) states: Vec<f64>,
}

impl<M, U> Default for SolverWorkspace<M, U> {
    fn default() -> Self {
        Self {
            first: 0.0,
            tolerance: TOLERANCE,
            log: Log::default(),
            scratch: None,
        }
    }
}
