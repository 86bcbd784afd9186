//! Inputs over a step, for models and instances: evaluates the polynomials that the importer's
//! input derivatives define, and holds the inputs at their values at the end of the step.

use super::input::InputPolynomial;
use super::layout::Layout;
use super::model::{Model, real_inputs};
use super::state::{HeldInput, State};
use super::storage::Accessor;
use super::value::Value;

impl<I: Clone + Default> InputPolynomial<I> {
    /// The inputs `s` seconds into the step; their [`value`](Self::value) without derivatives.
    #[inline]
    pub fn at<M: Model<Input = I>>(&self, s: f64) -> I {
        let mut u = self.value.clone();
        if self.order > 0 {
            taylor::<M>(self, s, 0, &mut u);
        }
        u
    }
}

/// Writes the `order`-th time derivative of all Real inputs, `s` seconds into the step, to `to`;
/// other inputs are not changed.
fn taylor<M: Model>(u: &InputPolynomial<M::Input>, s: f64, order: usize, to: &mut M::Input) {
    for (i, field) in real_inputs::<M>(&u.value) {
        // Horner from the highest order down: a_k + s/(k − order + 1)·(…), a_k the k-th derivative
        // at the start.
        let mut sum = 0.0;
        for k in (order..=u.order).rev() {
            let a_k = if k == 0 {
                &u.value
            } else {
                &u.derivatives[k - 1]
            };
            sum = field.get(a_k, i) + sum * s / (k - order + 1) as f64;
        }
        *field.get_mut(to, i) = sum;
    }
}

impl<M: Model> State<M> {
    /// The inputs over the next step: the present ones, with the derivatives given for that step.
    #[inline]
    pub(crate) fn input_polynomial(&self) -> InputPolynomial<M::Input> {
        InputPolynomial {
            value: self.input().clone(),
            derivatives: self.input.derivatives.clone(),
            order: self.input.order,
        }
    }

    /// First derivative of the inputs: that for the next step, else that at the end of the last.
    pub(crate) fn input_slope(&self) -> M::Input {
        let mut slope = self.input.derivatives[0].clone(); // zero where none was given
        if let Some(held) = &self.held_input {
            for (i, field) in real_inputs::<M>(&self.input.value) {
                *field.get_mut(&mut slope, i) += field.get(&held.slope, i); // one of them is zero
            }
        }
        slope
    }

    /// Whether each input has the value that was set, and keeps it in the next step.
    #[inline]
    pub(crate) fn is_held(&self) -> bool {
        self.input.order == 0 && self.held_input.is_none()
    }

    /// Removes the derivatives of an input that was set to `value`, and the effect of earlier ones.
    #[cold]
    pub(crate) fn end_derivatives<T: Value>(
        &mut self,
        field: &Accessor<M::Input, T>,
        i: usize,
        value: T,
    ) {
        if self.input.order > 0 {
            for derivative in &mut self.input.derivatives {
                *field.get_mut(derivative, i) = T::default();
            }
        }
        if let Some(held) = &mut self.held_input {
            *field.get_mut(&mut held.value, i) = value;
            *field.get_mut(&mut held.slope, i) = T::default();
        }
    }

    /// Adds to the count of an input's sets.
    pub(crate) fn count_sets(&mut self, counter: fn(&mut M::Input) -> &mut u32, sets: u32) {
        let count = counter(&mut self.input.value);
        *count = count.wrapping_add(sets);
        let count = *count;
        if let Some(held) = &mut self.held_input {
            *counter(&mut held.value) = count;
        }
    }

    /// Sets one derivative of a Real input for the next step.
    pub(crate) fn set_input_derivative(
        &mut self,
        field: &Accessor<M::Input, f64>,
        i: usize,
        order: usize,
        value: f64,
    ) {
        *field.get_mut(&mut self.input.derivatives[order - 1], i) = value;
        self.input.order = self.input.order.max(order);
        if let Some(held) = &mut self.held_input {
            *field.get_mut(&mut held.slope, i) = 0.0;
        }
    }

    /// After a step of `h` s: the inputs are held at the values that their derivatives have led to.
    #[inline]
    pub(crate) fn hold_inputs(&mut self, h: f64, layout: &Layout<M>) {
        if self.input.order > 0 {
            let polynomial = self.input_polynomial();
            let mut slope = layout.zero(&polynomial.value);
            taylor::<M>(&polynomial, h, 1, &mut slope);
            let value = polynomial.at::<M>(h);
            self.held_input = Some(HeldInput { value, slope });
            self.input.derivatives = std::array::from_fn(|_| layout.zero(&self.input.value));
            self.input.order = 0;
        } else if let Some(held) = &mut self.held_input {
            held.slope = layout.zero(&held.value);
        }
    }
}
