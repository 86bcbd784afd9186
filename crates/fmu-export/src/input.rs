//! Inputs over a communication step: value and time derivatives at its start.

use crate::{Model, layout};
use serde::{Deserialize, Serialize};

/// Highest order of input derivative that is kept; higher orders are refused.
pub const MAX_INPUT_DERIVATIVE: usize = 3;

/// `u(t + s) = Σ_k u⁽ᵏ⁾ sᵏ/k!`: the inputs over one communication step, `s` in s from its start.
///
/// Only Real inputs have derivatives; Integer and Boolean ones keep their value.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct InputPolynomial<I> {
    pub(crate) value: I,
    pub(crate) derivatives: [I; MAX_INPUT_DERIVATIVE],
    pub(crate) order: usize,
}

impl<I: Copy + Default> InputPolynomial<I> {
    /// Inputs that are held.
    pub fn held(value: I) -> Self {
        Self {
            value,
            derivatives: [I::default(); MAX_INPUT_DERIVATIVE],
            order: 0,
        }
    }

    /// Inputs with their time derivatives, first order first; at most [`MAX_INPUT_DERIVATIVE`] are kept.
    pub fn with_derivatives(value: I, derivatives: &[I]) -> Self {
        let mut polynomial = Self::held(value);
        for (to, from) in polynomial.derivatives.iter_mut().zip(derivatives) {
            *to = *from;
            polynomial.order += 1;
        }
        polynomial
    }

    /// The inputs at the start of the step.
    #[inline]
    pub fn value(&self) -> &I {
        &self.value
    }

    /// Highest order the importer has given for this step; 0: the inputs are held.
    #[inline]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The `k`-th time derivative (`k` = 0: the value), zero beyond [`order`](Self::order). Integer and Boolean fields of it mean nothing.
    #[inline]
    pub fn derivative(&self, k: usize) -> I {
        match k {
            0 => self.value,
            k if k <= self.order => self.derivatives[k - 1],
            _ => I::default(),
        }
    }

    /// The inputs `s` seconds into the step. Free when they are held; else it walks the table of `M`.
    #[inline]
    pub fn at<M: Model<Input = I>>(&self, s: f64) -> I {
        if self.order == 0 {
            self.value
        } else {
            layout::taylor::<M>(self, s, 0)
        }
    }

    /// Makes the inputs held again.
    #[inline]
    pub(crate) fn clear_derivatives(&mut self) {
        if self.order > 0 {
            self.derivatives = [I::default(); MAX_INPUT_DERIVATIVE];
            self.order = 0;
        }
    }
}
