//! Inputs over a communication step: value and time derivatives at its start.

use crate::instance::{Reached, State};
use crate::value::Value;
use crate::variable::Write;
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
    fn clear_derivatives(&mut self) {
        if self.order > 0 {
            self.derivatives = [I::default(); MAX_INPUT_DERIVATIVE];
            self.order = 0;
        }
    }
}

impl<M: Model> State<M> {
    /// The inputs of the step to come: from what acts now, with the derivatives given for it.
    #[inline]
    pub(crate) fn input_course(&self) -> InputPolynomial<M::Input> {
        InputPolynomial {
            value: *self.input(),
            ..self.input
        }
    }

    /// First derivative of the inputs: what was given for the step to come, else where the last one ended.
    pub(crate) fn input_slope(&self) -> M::Input {
        let mut slope = self.input.derivative(1);
        if let Some(reached) = &self.reached {
            for (i, place) in layout::real_inputs::<M>(&self.input.value) {
                *place.get_mut(&mut slope, i) += place.get(&reached.slope, i); // one of them is zero
            }
        }
        slope
    }

    /// Sets one input; its derivatives end. Whether anything is different now.
    #[inline]
    pub(crate) fn set_input<T: Value>(
        &mut self,
        place: &Write<M::Input, T>,
        i: usize,
        value: T,
    ) -> bool {
        let slot = place.get_mut(&mut self.input.value, i);
        let old = std::mem::replace(slot, value);
        if self.input.order == 0 && self.reached.is_none() {
            return !old.is_same(value);
        }
        for derivative in &mut self.input.derivatives {
            *place.get_mut(derivative, i) = T::default();
        }
        if let Some(reached) = &mut self.reached {
            *place.get_mut(&mut reached.value, i) = value;
            *place.get_mut(&mut reached.slope, i) = T::default();
        }
        true
    }

    /// Counts that an input was set.
    pub(crate) fn count_set(&mut self, counter: fn(&mut M::Input) -> &mut u32) {
        let count = counter(&mut self.input.value);
        *count = count.wrapping_add(1);
        let count = *count;
        if let Some(reached) = &mut self.reached {
            *counter(&mut reached.value) = count;
        }
    }

    /// Gives one derivative of a Real input for the next step.
    pub(crate) fn set_input_derivative(
        &mut self,
        place: &Write<M::Input, f64>,
        i: usize,
        order: usize,
        value: f64,
    ) {
        *place.get_mut(&mut self.input.derivatives[order - 1], i) = value;
        self.input.order = self.input.order.max(order);
        if let Some(reached) = &mut self.reached {
            *place.get_mut(&mut reached.slope, i) = 0.0;
        }
    }

    /// After a step of `h` s: derivatives have done their duty, the inputs are held where these have taken them.
    #[inline]
    pub(crate) fn hold_inputs(&mut self, h: f64) {
        if self.input.order > 0 {
            let course = self.input_course();
            self.reached = Some(Reached {
                value: course.at::<M>(h),
                slope: layout::taylor::<M>(&course, h, 1),
            });
            self.input.clear_derivatives();
        } else if let Some(reached) = &mut self.reached {
            reached.slope = M::Input::default();
        }
    }
}
