//! What an instance has computed for Model Exchange.

use super::model::Model;

/// What an instance computes for Model Exchange.
pub(crate) struct EquationCache<M> {
    /// A copy of the model whose states are derivatives.
    pub(super) rate: Option<M>,
    /// Derivatives, and behind them the event indicators.
    pub(super) numbers: Vec<f64>,
    /// Which of the two agree with state, inputs and time.
    pub(super) fresh: [bool; 2],
    /// States that are read or set.
    pub(super) states: Vec<f64>,
}

impl<M> Default for EquationCache<M> {
    fn default() -> Self {
        Self {
            rate: None,
            numbers: Vec::new(),
            fresh: [false; 2],
            states: Vec::new(),
        }
    }
}

impl<M: Model> EquationCache<M> {
    /// Marks what was computed as out of date.
    #[inline(always)]
    pub(super) fn invalidate(&mut self) {
        if M::MODEL_EXCHANGE.is_some() {
            self.fresh = [false; 2];
        }
    }
}
