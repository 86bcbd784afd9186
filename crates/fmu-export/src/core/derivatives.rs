//! Input, output and directional derivatives.

use super::causality::Causality;
use super::fault::{Fault, discard, refuse};
use super::instance::Instance;
use super::layout::Element;
use super::message::Kind;
use super::model::Variable;
use super::phase::Phase;
use super::place::{Place, Write};
use super::sizes::zero;
use super::value::Value;
use std::collections::BTreeMap;

use crate::{Evaluation, MAX_INPUT_DERIVATIVE, Model};

/// ∛ε, the step of central differences. A number, since some platforms would call their own `cbrt`
/// for it.
pub(super) const ROOT_OF_EPSILON: f64 = 6.055_454_452_393_343e-6;

/// A Real input: index in its row, row, place.
type KnownInput<M> = (
    usize,
    &'static Variable<M>,
    &'static Write<<M as Model>::Input, f64>,
);

impl<M: Model> Instance<M> {
    /// Derivatives of `n` Real inputs for the next step: the `order(k)`-th of `element(k)` is
    /// `value(k)`.
    pub(crate) fn set_input_derivatives(
        &mut self,
        n: usize,
        element: impl Fn(usize) -> u32,
        order: impl Fn(usize) -> i32,
        value: impl Fn(usize) -> f64,
    ) -> Result<(), Fault> {
        let mut highest = 0;
        for k in 0..n {
            let (i, row) = self.layout.find(element(k))?;
            let name = || row.element_name(i);
            if !matches!(row.place, Place::RealIn(_)) || row.discrete {
                let (name, kind) = (name(), row.kind(self.names));
                return refuse!(
                    "`{name}` is {kind} without derivatives; it must be a continuous Real input"
                );
            }
            let (order, value) = (order(k), value(k));
            if order < 1 {
                let name = name();
                return refuse!("`{name}`: order of derivative = {order} must be at least 1");
            }
            if !value.is_finite() {
                let name = name();
                return discard!("`{name}`: derivative of order {order} = {value} must be finite");
            }
            highest = highest.max(order as usize);
        }
        if !M::INFO.input_derivatives {
            return Ok(());
        }
        for k in 0..n {
            let ((i, row), order) = (self.layout.find(element(k))?, order(k) as usize);
            if let Place::RealIn(place) = &row.place
                && order <= MAX_INPUT_DERIVATIVE
            {
                self.state.set_input_derivative(place, i, order, value(k));
            }
        }
        if highest > MAX_INPUT_DERIVATIVE && !self.has_warned_of_order {
            self.has_warned_of_order = true;
            self.tell(
                Kind::Warning,
                format!("input derivatives of order {highest} are left out: up to {MAX_INPUT_DERIVATIVE} are used"),
            );
        }
        Ok(())
    }

    /// Refuses output derivatives where the model has none.
    pub(crate) fn has_output_derivatives(&self) -> Result<(), Fault> {
        match M::INFO.output_derivatives {
            true => Ok(()),
            false => {
                refuse!("this FMU has no output derivatives (maxOutputDerivativeOrder = 0)")
            }
        }
    }

    /// Refuses output derivatives of another order than the first.
    pub(crate) fn check_first_order(
        &self,
        n: usize,
        number: impl Fn(usize) -> u32,
        order: impl Fn(usize) -> i32,
    ) -> Result<(), Fault> {
        let Some(k) = (0..n).find(|&k| order(k) != 1) else {
            return Ok(());
        };
        let (i, row) = self.layout.find(number(k))?;
        let (name, order) = (row.element_name(i), order(k));
        refuse!("`{name}`: order of derivative = {order} must be 1")
    }

    /// First time derivatives of `n` Real outputs.
    pub(crate) fn output_derivatives(
        &mut self,
        n: usize,
        element: impl Fn(usize) -> u32,
        put: impl FnMut(usize, f64),
    ) -> Result<(), Fault> {
        for k in 0..n {
            let (i, row) = self.layout.find(element(k))?;
            if !matches!(row.place, Place::RealOut(_)) || row.causality != Causality::Output {
                let (name, kind) = (row.element_name(i), row.kind(self.names));
                return refuse!("`{name}` is {kind}; it must be a Real output");
            }
        }
        if n == 0 {
            return Ok(());
        }
        self.evaluate()?;
        let (state, (model, now)) = (&self.state, self.evaluated());
        let (p, u, u_dot) = (&state.parameters, state.input(), state.input_slope());
        let y_dot = model.output_derivative(p, u, now, &u_dot)?;
        self.read_outputs(n, element, &y_dot, put, "time derivative")
    }

    /// A Real input: index in its row, row, place.
    fn known(&self, number: u32) -> Result<KnownInput<M>, Fault> {
        let (i, row) = self.layout.find(number)?;
        let Place::RealIn(place) = &row.place else {
            let (name, kind) = (row.element_name(i), row.kind(self.names));
            let real = self.names.real;
            return refuse!("known `{name}` is {kind}; it must be a {real} input");
        };
        Ok((i, row, place))
    }

    /// A Real output or local variable.
    fn unknown(&self, number: u32) -> Result<Element<M>, Fault> {
        let (i, row) = self.layout.find(number)?;
        if !matches!(row.place, Place::RealOut(_)) {
            let (name, kind) = (row.element_name(i), row.kind(self.names));
            let real = self.names.real;
            return refuse!("unknown `{name}` is {kind}; it must be a {real} output");
        }
        Ok((i, row))
    }

    /// ∂unknown/∂known · seed: at fixed state while stepping, through the initialization before.
    pub(crate) fn directional_derivative(
        &mut self,
        unknowns: usize,
        unknown: impl Fn(usize) -> u32,
        knowns: usize,
        known: impl Fn(usize) -> u32,
        seed: impl Fn(usize) -> f64,
        put: impl FnMut(usize, f64),
    ) -> Result<(), Fault> {
        let mut du = match self.layout.has_vectors() {
            true => zero::<M>(self.state.input()),
            false => M::Input::default(),
        };
        // Largest seed in units of the nominal values.
        let mut largest: f64 = 0.0;
        for k in 0..knowns {
            let (i, row, place) = self.known(known(k))?;
            let seed = seed(k);
            if !seed.is_finite() {
                let name = row.element_name(i);
                return discard!("known `{name}`: seed = {seed} must be finite");
            }
            *place.get_mut(&mut du, i) += seed;
            largest = largest.max(seed.abs() / row.nominal.unwrap_or(1.0));
        }
        for k in 0..unknowns {
            self.unknown(unknown(k))?;
        }
        if unknowns == 0 {
            return Ok(());
        }
        if self.state.phase == Phase::Initialization {
            return self.initial_derivative(&du, largest, unknowns, unknown, put);
        }
        self.evaluate()?;
        let (state, (model, now)) = (&self.state, self.evaluated());
        let dy = model.directional_derivative(&state.parameters, state.input(), now, &du)?;
        self.read_outputs(unknowns, unknown, &dy, put, "directional derivative")
    }

    /// seed · ∂unknown/∂known, the transpose of
    /// [`directional_derivative`](Self::directional_derivative).
    pub(crate) fn adjoint_derivative(
        &mut self,
        unknowns: &[u32],
        seed: &[f64],
        knowns: &[u32],
    ) -> Result<Vec<f64>, Fault> {
        for &number in knowns {
            self.known(number)?;
        }
        let weights = self.weights(unknowns, seed)?;
        if unknowns.is_empty() {
            return Ok(vec![0.0; knowns.len()]);
        }
        if self.state.phase == Phase::Initialization {
            return self.initial_adjoint(unknowns, seed, knowns);
        }
        self.evaluate()?;
        let (state, (model, now)) = (&self.state, self.evaluated());
        let adjoint = model.adjoint_derivative(&state.parameters, state.input(), now, &weights)?;
        let read = |&number: &u32| {
            let (i, row, place) = self.known(number)?;
            let value = place.get(&adjoint, i);
            if !value.is_finite() {
                let name = row.element_name(i);
                return refuse!("adjoint derivative by `{name}` became {value}; it must be finite");
            }
            Ok(value)
        };
        knowns.iter().map(read).collect()
    }

    /// A weight for each element of the Real outputs and local variables, in the order of the
    /// table.
    fn weights(&self, unknowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Fault> {
        let is_output = |row: &Variable<M>| matches!(row.place, Place::RealOut(_));
        let mut positions = BTreeMap::new();
        for (number, _) in (self.layout.numbered()).filter(|(_, (_, row))| is_output(row)) {
            positions.insert(number, positions.len());
        }
        let mut weights = vec![0.0; positions.len()];
        for (&number, &seed) in unknowns.iter().zip(seed) {
            let (i, row) = self.unknown(number)?;
            if !seed.is_finite() {
                let name = row.element_name(i);
                return discard!("unknown `{name}`: seed = {seed} must be finite");
            }
            weights[positions[&number]] += seed;
        }
        Ok(weights)
    }

    /// The adjoint before the state is settled: the columns of the difference one by one.
    fn initial_adjoint(
        &mut self,
        unknowns: &[u32],
        seed: &[f64],
        knowns: &[u32],
    ) -> Result<Vec<f64>, Fault> {
        let column = |&known: &u32| {
            let mut sum = 0.0;
            self.directional_derivative(
                unknowns.len(),
                |k| unknowns[k],
                1,
                |_| known,
                |_| 1.0,
                |k, dy| sum += seed[k] * dy,
            )?;
            Ok(sum)
        };
        knowns.iter().map(column).collect()
    }

    /// The same before the state is settled: outputs depend on inputs through [`Model::initialize`]
    /// too, so it is a central difference of all of it, with a step of ∛ε of the nominal values;
    /// its error is some ε^⅔ of them.
    fn initial_derivative(
        &self,
        du: &M::Input,
        largest: f64,
        unknowns: usize,
        unknown: impl Fn(usize) -> u32,
        mut put: impl FnMut(usize, f64),
    ) -> Result<(), Fault> {
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let step = ROOT_OF_EPSILON / scale;
        // At a bound the difference is one-sided: the model sees no input beyond it.
        let [less, more] = [-step, step].map(|step| match self.moved_inputs(du, step) {
            Some(u) => (step, u),
            None => (0.0, self.state.input().clone()),
        });
        let y_less = self.initial_output(&less.1)?;
        let y_more = self.initial_output(&more.1)?;
        for k in 0..unknowns {
            let (i, row) = self.layout.find(unknown(k))?;
            if let Place::RealOut(place) = &row.place {
                let dy = (place.get(&y_more, i) - place.get(&y_less, i)) / (more.0 - less.0);
                if !dy.is_finite() {
                    let name = row.element_name(i);
                    return refuse!("derivative of `{name}` became {dy}; it must be finite");
                }
                put(k, dy);
            }
        }
        Ok(())
    }

    /// The inputs `u + step·du`, if they are in their bounds.
    fn moved_inputs(&self, du: &M::Input, step: f64) -> Option<M::Input> {
        let mut u = self.state.input().clone();
        for (i, row) in self.layout.iter() {
            if let Place::RealIn(place) = &row.place {
                let slot = place.get_mut(&mut u, i);
                *slot += step * place.get(du, i);
                if !slot.is_allowed(row) {
                    return None;
                }
            }
        }
        Some(u)
    }

    /// The outputs of a model that is initialized with the inputs `u`.
    fn initial_output(&self, u: &M::Input) -> Result<M::Output, Fault> {
        let p = &self.state.parameters;
        let model = M::initialize(p, u, self.state.start)?;
        let now = M::Evaluation::of(&model, p, u)?;
        Ok(model.output(p, u, &now)?)
    }

    /// Reads Real outputs, already checked to be such, from `from`.
    fn read_outputs(
        &self,
        n: usize,
        element: impl Fn(usize) -> u32,
        from: &M::Output,
        mut put: impl FnMut(usize, f64),
        what: &str,
    ) -> Result<(), Fault> {
        for k in 0..n {
            let (i, row) = self.layout.find(element(k))?;
            if let Place::RealOut(place) = &row.place {
                let value = place.get(from, i);
                if !value.is_finite() {
                    let name = row.element_name(i);
                    return refuse!("{what} of `{name}` became {value}; it must be finite");
                }
                put(k, value);
            }
        }
        Ok(())
    }
}
