//! Derivatives and event indicators that `model_exchange` computes, and whether they are valid.

use super::model::Model;

/// The two groups of equations, each computed together.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Equations {
    Derivatives = 0,
    Indicators = 1,
}

/// The results of a model's equations.
pub(crate) struct EquationCache<M> {
    /// A copy of the model that holds the derivatives in place of its states.
    pub(super) rate: Option<M>,
    /// All derivatives, followed by all event indicators.
    pub(super) numbers: Vec<f64>,
    /// Which [`Equations`] agree with state, inputs and time.
    pub(super) is_valid: [bool; 2],
    /// States that are read or set.
    pub(super) states: Vec<f64>,
}

impl<M> Default for EquationCache<M> {
    fn default() -> Self {
        Self {
            rate: None,
            numbers: Vec::new(),
            is_valid: [false; 2],
            states: Vec::new(),
        }
    }
}

impl<M: Model> EquationCache<M> {
    /// Marks the results as out of date.
    #[inline(always)]
    pub(super) fn invalidate(&mut self) {
        if M::MODEL_EXCHANGE.is_some() {
            self.is_valid = [false; 2];
        }
    }
}
