//! The workspace of an instance's solver, which `Ode` and `solver_step` reuse between steps.

use super::log::Log;
use fmu_solver::{Solver, TOLERANCE};

/// Solver workspace of a model `M` with inputs `U`, reused between steps.
pub struct SolverWorkspace<M, U> {
    /// The internal step to try first, s; 0 if not known. Only this and `next_event` affect the next
    /// step.
    pub(crate) first: f64,
    /// Time of the next time event, s: infinite if there is none, −infinite if the model has to look
    /// for events at the start of the next step, since something was set.
    pub(crate) next_event: f64,
    /// The tolerance of an internal step.
    pub(crate) tolerance: f64,
    /// Messages of the solver.
    pub(crate) log: Log,
    pub(super) scratch: Option<Box<Scratch<M, U>>>,
}

impl<M, U> SolverWorkspace<M, U> {
    /// Drops the scratch memory when the number of states changes.
    pub(crate) fn invalidate(&mut self) {
        self.scratch = None;
    }
}

#[cfg_attr(
    not(feature = "derive"),
    expect(dead_code, reason = "only models with derives use a solver")
)]
pub(super) struct Scratch<M, U> {
    pub(super) solver: Solver,
    /// The model at the solver's present point.
    pub(super) at: M,
    /// A copy of the model that holds the derivatives in place of its states.
    pub(super) rate: M,
    /// A direction of states, with zero inputs, if the model has directional derivatives.
    pub(super) direction: Option<(M, U)>,
    pub(super) states: Vec<f64>,
    /// Those that an event has left.
    pub(super) left: Vec<f64>,
    /// Rates before and after an event.
    pub(super) rates: [Vec<f64>; 2],
}

impl<M, U> Default for SolverWorkspace<M, U> {
    fn default() -> Self {
        Self {
            first: 0.0,
            next_event: f64::NEG_INFINITY,
            tolerance: TOLERANCE,
            log: Log::default(),
            scratch: None,
        }
    }
}
