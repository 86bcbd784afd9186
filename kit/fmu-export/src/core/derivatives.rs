//! Sets input derivatives, and gets output, directional and adjoint derivatives, for `fmi2` and
//! `fmi3`: the model's own, or differences where it has none.

use super::causality::Causality;
use super::fault::{Fault, discard, refuse};
use super::instance::Instance;
use super::layout::Element;
use super::message::Kind;
use super::model::Variable;
use super::phase::Phase;
use super::sizes;
use super::storage::{Accessor, Storage};
use super::value::Value;
use std::collections::BTreeMap;

use crate::{Evaluation, MAX_INPUT_DERIVATIVE, Model};

/// ∛ε, the step of central differences. Written out, because `cbrt` differs between platforms.
pub(crate) const ROOT_OF_EPSILON: f64 = 6.055_454_452_393_343e-6;

/// A known variable: a Real input or, for Model Exchange, a continuous state. Index in its row,
/// row, and the accessor of an input.
type Known<M> = (
    usize,
    &'static Variable<M>,
    Option<&'static Accessor<<M as Model>::Input, f64>>,
);

/// A direction: seeds of the inputs and, unless all are zero, of the states; and the largest seed
/// relative to the nominal values.
struct Direction<M: Model> {
    du: M::Input,
    dx: Option<Vec<f64>>,
    largest: f64,
}

/// The values that are differentiated: outputs, and derivatives and event indicators as needed.
type Observation<M> = (<M as Model>::Output, Vec<f64>);

impl<M: Model> Instance<M> {
    /// Sets derivatives of `n` Real inputs for the next step: the `order(k)`-th derivative of
    /// `element(k)` is `value(k)`.
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
            let name = || self.name(row, i);
            if !matches!(row.storage, Storage::RealIn(_)) || row.discrete {
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
            if let Storage::RealIn(field) = &row.storage
                && order <= MAX_INPUT_DERIVATIVE
            {
                self.state.set_input_derivative(field, i, order, value(k));
            }
        }
        if highest > MAX_INPUT_DERIVATIVE && !self.has_warned_of_order {
            self.has_warned_of_order = true;
            self.report(
                Kind::Warning,
                format!("input derivatives of order {highest} are left out: up to {MAX_INPUT_DERIVATIVE} are used"),
            );
        }
        Ok(())
    }

    /// Refuses output derivatives if the model does not support them.
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
        let (name, order) = (self.name(row, i), order(k));
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
            if !matches!(row.storage, Storage::RealOut(_)) || row.causality != Causality::Output {
                let (name, kind) = (self.name(row, i), row.kind(self.names));
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
        let found = (y_dot, Vec::new());
        let value = |e| self.value(e, &found);
        self.put_values(n, element, value, put, "time derivative")
    }

    fn known(&self, number: u32) -> Result<Known<M>, Fault> {
        let (i, row) = self.layout.find(number)?;
        match &row.storage {
            Storage::RealIn(field) => Ok((i, row, Some(field))),
            _ if row.is_state() => Ok((i, row, None)),
            _ => {
                let (name, kind, real) = (self.name(row, i), row.kind(self.names), self.names.real);
                let state = if M::MODEL_EXCHANGE.is_some() {
                    " or a continuous state"
                } else {
                    ""
                };
                refuse!("known `{name}` is {kind}; it must be a {real} input{state}")
            }
        }
    }

    /// A Real output or local variable, the derivative of a state, or an event indicator.
    fn unknown(&self, number: u32) -> Result<Element<M>, Fault> {
        let (i, row) = self.layout.find(number)?;
        if !(matches!(row.storage, Storage::RealOut(_)) || row.storage.is_equation()) {
            let (name, kind) = (self.name(row, i), row.kind(self.names));
            let real = self.names.real;
            return refuse!("unknown `{name}` is {kind}; it must be a {real} output");
        }
        Ok((i, row))
    }

    /// The direction with these seeds of `n` knowns.
    fn direction(
        &self,
        n: usize,
        known: impl Fn(usize) -> u32,
        seed: impl Fn(usize) -> f64,
    ) -> Result<Direction<M>, Fault> {
        let du = self.layout.zero(self.state.input());
        let mut all = Direction {
            du,
            dx: None,
            largest: 0.0,
        };
        for k in 0..n {
            let (i, row, field) = self.known(known(k))?;
            let seed = seed(k);
            if !seed.is_finite() {
                let name = self.name(row, i);
                return discard!("known `{name}`: seed = {seed} must be finite");
            }
            match field {
                Some(field) => *field.get_mut(&mut all.du, i) += seed,
                None if seed == 0.0 => {}
                None => {
                    let dx = all.dx.get_or_insert_with(|| vec![0.0; self.layout.states]);
                    dx[self.layout.offset(row) + i] += seed;
                }
            }
            all.largest = all.largest.max(seed.abs() / row.nominal.unwrap_or(1.0));
        }
        Ok(all)
    }

    /// Refuses directional and adjoint derivatives if there are none, as the attribute `flag` says.
    pub(crate) fn has_derivatives(&self, flag: &str) -> Result<(), Fault> {
        match M::INFO.directional_derivatives || M::MODEL_EXCHANGE.is_some() {
            true => Ok(()),
            false => refuse!("this FMU has no such derivatives ({flag} = false)"),
        }
    }

    /// ∂unknown/∂known · seed, at fixed states; in Initialization Mode through the initialization.
    pub(crate) fn directional_derivative(
        &mut self,
        unknowns: usize,
        unknown: impl Fn(usize) -> u32,
        knowns: usize,
        known: impl Fn(usize) -> u32,
        seed: impl Fn(usize) -> f64,
        put: impl FnMut(usize, f64),
    ) -> Result<(), Fault> {
        let direction = self.direction(knowns, known, seed)?;
        // How many derivatives of states and event indicators must be computed.
        let mut needed = 0;
        for k in 0..unknowns {
            let (i, row) = self.unknown(unknown(k))?;
            if row.storage.is_equation() {
                needed = needed.max(self.layout.offset(row) + i + 1);
            }
        }
        if unknowns == 0 {
            return Ok(());
        }
        match self.analytic(&direction, needed)? {
            Some(found) => {
                let value = |e| self.value(e, &found);
                self.put_values(unknowns, unknown, value, put, "directional derivative")
            }
            None => self.difference(&direction, needed, unknowns, &unknown, &mut { put }),
        }
    }

    /// The derivative from the model's own implementation, if it has one.
    fn analytic(
        &mut self,
        direction: &Direction<M>,
        needed: usize,
    ) -> Result<Option<Observation<M>>, Fault> {
        let is_of_outputs = direction.dx.is_none() && needed == 0;
        let of_outputs = is_of_outputs && M::INFO.directional_derivatives;
        let equations = M::MODEL_EXCHANGE.filter(|x| x.directional.is_some());
        let of_equations = equations.filter(|_| needed <= self.layout.states);
        if self.state.phase == Phase::Initialization || !of_outputs && of_equations.is_none() {
            return Ok(None);
        }
        self.evaluate()?;
        let (state, (model, now)) = (&self.state, self.evaluated());
        let (p, u, du) = (&state.parameters, state.input(), &direction.du);
        if of_outputs {
            let dy = model.directional_derivative(p, u, now, du)?;
            return Ok(Some((dy, Vec::new())));
        }
        let zero = || vec![0.0; self.layout.states];
        let mut dx = direction.dx.clone().unwrap_or_else(zero);
        let dy = of_equations
            .and_then(|x| x.directional_derivative(model, (p, u, now, state.time), &mut dx, du));
        Ok(dy.transpose()?.map(|dy| (dy, dx)))
    }

    /// seed · ∂unknown/∂known, the transpose of
    /// [`directional_derivative`](Self::directional_derivative).
    pub(crate) fn adjoint_derivative(
        &mut self,
        unknowns: &[u32],
        seed: &[f64],
        knowns: &[u32],
    ) -> Result<Vec<f64>, Fault> {
        let mut by_columns = !M::INFO.directional_derivatives;
        for &number in knowns {
            by_columns |= self.known(number)?.2.is_none();
        }
        let weights = self.weights(unknowns, seed)?;
        for &number in unknowns {
            by_columns |= self.unknown(number)?.1.storage.is_equation();
        }
        if unknowns.is_empty() {
            return Ok(vec![0.0; knowns.len()]);
        }
        if self.state.phase == Phase::Initialization || by_columns {
            return self.adjoint_by_columns(unknowns, seed, knowns);
        }
        self.evaluate()?;
        let (state, (model, now)) = (&self.state, self.evaluated());
        let adjoint = model.adjoint_derivative(&state.parameters, state.input(), now, &weights)?;
        let read = |&number: &u32| {
            let (i, _, field) = self.known(number)?;
            let value = field.map_or(0.0, |field| field.get(&adjoint, i));
            self.finite_adjoint(number, value)
        };
        knowns.iter().map(read).collect()
    }

    /// The adjoint derivative with respect to a known, if it is finite.
    fn finite_adjoint(&self, known: u32, value: f64) -> Result<f64, Fault> {
        if value.is_finite() {
            return Ok(value);
        }
        let (i, row, _) = self.known(known)?;
        let name = self.name(row, i);
        refuse!("adjoint derivative by `{name}` became {value}; it must be finite")
    }

    /// The weights of all elements of Real outputs and local variables, in the order of the table.
    fn weights(&self, unknowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Fault> {
        let is_output = |row: &Variable<M>| matches!(row.storage, Storage::RealOut(_));
        let mut positions = BTreeMap::new();
        for (number, _) in (self.layout.numbered()).filter(|(_, (_, row))| is_output(row)) {
            positions.insert(number, positions.len());
        }
        let mut weights = vec![0.0; positions.len()];
        for (&number, &seed) in unknowns.iter().zip(seed) {
            let (i, row) = self.unknown(number)?;
            if !seed.is_finite() {
                let name = self.name(row, i);
                return discard!("unknown `{name}`: seed = {seed} must be finite");
            }
            if let Some(&position) = positions.get(&number) {
                weights[position] += seed;
            }
        }
        Ok(weights)
    }

    /// The adjoint derivative computed from directional derivatives, one for each known.
    fn adjoint_by_columns(
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
            self.finite_adjoint(known, sum)
        };
        knowns.iter().map(column).collect()
    }

    /// A central difference with a step of ∛ε of the nominal values; its relative error is about
    /// ε^⅔. In Initialization Mode it includes the dependence through [`Model::initialize`].
    fn difference(
        &mut self,
        direction: &Direction<M>,
        needed: usize,
        unknowns: usize,
        unknown: &dyn Fn(usize) -> u32,
        put: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault> {
        let largest = direction.largest;
        let step = ROOT_OF_EPSILON / if largest > 0.0 { largest } else { 1.0 };
        // At a bound the difference is one-sided: no input exceeds its bounds.
        let [less, more] = [-step, step].map(|step| match self.moved_inputs(&direction.du, step) {
            Some(u) => (step, u),
            None => (0.0, self.state.input().clone()),
        });
        if less.0 == more.0 {
            let parts = self.split(direction);
            if parts.len() > 1 {
                let mut sums = vec![0.0; unknowns];
                for part in &parts {
                    self.difference(part, needed, unknowns, unknown, &mut |k, dy| sums[k] += dy)?;
                }
                sums.iter().enumerate().for_each(|(k, dy)| put(k, *dy));
                return Ok(());
            }
        }
        let y_less = self.observe(direction, needed, &less)?;
        let y_more = self.observe(direction, needed, &more)?;
        let slope = |e| (self.value(e, &y_more) - self.value(e, &y_less)) / (more.0 - less.0);
        self.put_values(unknowns, unknown, slope, put, "derivative")
    }

    /// Splits the direction into the states and each changing input. Inputs at opposite bounds
    /// cannot change together, but one at a time.
    fn split(&self, direction: &Direction<M>) -> Vec<Direction<M>> {
        let zero = || self.layout.zero(self.state.input());
        let states = direction.dx.is_some().then(|| Direction {
            du: zero(),
            dx: direction.dx.clone(),
            largest: direction.largest,
        });
        let inputs = (self.layout.iter()).filter_map(|(i, row)| match &row.storage {
            Storage::RealIn(field) if field.get(&direction.du, i) != 0.0 => {
                let (seed, mut du) = (field.get(&direction.du, i), zero());
                *field.get_mut(&mut du, i) = seed;
                let largest = seed.abs() / row.nominal.unwrap_or(1.0);
                Some(Direction {
                    du,
                    dx: None,
                    largest,
                })
            }
            _ => None,
        });
        states.into_iter().chain(inputs).collect()
    }

    /// The values with the inputs `u` and the states moved by `step`; in Initialization Mode those
    /// of a model initialized with these inputs. Only the first `needed` equations are computed.
    fn observe(
        &self,
        direction: &Direction<M>,
        needed: usize,
        (step, u): &(f64, M::Input),
    ) -> Result<Observation<M>, Fault> {
        let p = &self.state.parameters;
        let mut model = match &self.state.model {
            Some(model) if self.state.phase != Phase::Initialization => model.clone(),
            _ => M::initialize(p, u, self.state.start)?,
        };
        if let (Some(equations), Some(dx)) = (M::MODEL_EXCHANGE, &direction.dx) {
            let mut x = vec![0.0; dx.len()];
            (equations.states)(&model, &mut x);
            x.iter_mut().zip(dx).for_each(|(x, dx)| *x += step * dx);
            (equations.set_states)(&mut model, &x);
        }
        let now = M::Evaluation::new(&model, p, u)?;
        let mut y = sizes::output::<M>(p);
        model.output_at(p, u, &now, self.state.time, &mut y)?;
        let Some(equations) = M::MODEL_EXCHANGE.filter(|_| needed > 0) else {
            return Ok((y, Vec::new()));
        };
        let (states, indicators) = (self.layout.states, self.layout.indicators);
        let (at, mut rate) = ((p, u, &now, self.state.time), model.clone());
        let mut numbers = vec![0.0; states + indicators];
        if needed > states {
            equations.derivatives_and_indicators(&model, at, &mut rate, states, &mut numbers)?;
        } else {
            equations.write_derivatives(&model, at, &mut rate, &mut numbers[..states])?;
        }
        Ok((y, numbers))
    }

    /// The inputs `u + step·du`, if they are within their bounds.
    fn moved_inputs(&self, du: &M::Input, step: f64) -> Option<M::Input> {
        let mut u = self.state.input().clone();
        for (i, row) in self.layout.iter() {
            if let Storage::RealIn(field) = &row.storage {
                let slot = field.get_mut(&mut u, i);
                *slot += step * field.get(du, i);
                if !slot.is_allowed(row) {
                    return None;
                }
            }
        }
        Some(u)
    }

    /// The value of an unknown in an observation.
    fn value(&self, (i, row): Element<M>, (y, equations): &Observation<M>) -> f64 {
        match &row.storage {
            Storage::RealOut(field) => field.get(y, i),
            _ => equations[self.layout.offset(row) + i],
        }
    }

    /// Passes the value of each of `n` unknowns to `put`, if it is finite.
    fn put_values(
        &self,
        n: usize,
        element: impl Fn(usize) -> u32,
        value: impl Fn(Element<M>) -> f64,
        mut put: impl FnMut(usize, f64),
        what: &str,
    ) -> Result<(), Fault> {
        for k in 0..n {
            let (i, row) = self.layout.find(element(k))?;
            let value = value((i, row));
            if !value.is_finite() {
                let name = self.name(row, i);
                return refuse!("{what} of `{name}` became {value}; it must be finite");
            }
            put(k, value);
        }
        Ok(())
    }
}
