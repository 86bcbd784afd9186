//! Tests in `check` for Model Exchange: the states are those of the table, all derivatives and
//! event indicators are written, and they depend only on what they declare.

use super::derivatives::shift_input;
use super::model_check::{ModelCheck, output};
use super::point::Point;
use crate::core::causality::{Causality, Dependencies};
use crate::core::dependencies::elements;
use crate::core::layout::Element;
use crate::core::model::{ModelExchange, Variable, real_outputs, zero};
use crate::core::storage::Storage;
use crate::core::value::Value;
use crate::{Evaluation, Model, ModelError};

impl<M: Model> ModelCheck<M> {
    /// Checks that the states are those of the table, and that all derivatives and event indicators
    /// are written.
    pub(super) fn equations(&mut self) {
        let Some(equations) = M::MODEL_EXCHANGE.or(M::EVENTS) else {
            return;
        };
        let checked = self.check_indicators(equations);
        let checked = checked.and_then(|()| match M::MODEL_EXCHANGE {
            Some(equations) => self.check_equations(equations),
            None => Ok(()),
        });
        self.problems.extend(checked.err());
    }

    fn check_equations(&self, equations: ModelExchange<M>) -> Result<(), String> {
        let (Point(p, u), n) = (&self.start, self.layout.states);
        let what = |error: ModelError| format!("equations with the start values: {error}");
        let mut model = M::initialize(p, u, M::INFO.experiment.start).map_err(what)?;
        let (mut x, mut moved) = (vec![0.0; n], vec![0.0; n]);
        (equations.states)(&model, &mut x);
        for (k, x) in x.iter_mut().enumerate() {
            *x += 1e-3 * x.abs().max(1e-3) * (k + 1) as f64;
        }
        (equations.set_states)(&mut model, &x);
        (equations.states)(&model, &mut moved);
        let now = M::Evaluation::new(&model, p, u).map_err(what)?;
        let y = model.output(p, u, &now).map_err(what)?;
        let texts = output(&self.layout, &model, &self.start).map_err(what)?;
        let elements = self.layout.iter().zip(&texts);
        let rates = elements.filter(|((_, row), _)| row.storage.is_derivative());
        for (k, (&state, ((i, row), text))) in self.knowns.states.iter().zip(rates).enumerate() {
            let name = self.name(state);
            let (_, shown) = self.layout.iter().nth(state).expect("counted");
            if let Storage::RealOut(field) = &shown.storage
                && !(moved[k].is_same(&x[k]) && field.get(&y, i).is_same(&x[k]))
            {
                return Err(format!(
                    "state {k} was set to {}, but `states` gives {}, and `{name}` is {}",
                    x[k],
                    moved[k],
                    field.get(&y, i)
                ));
            }
            if *text == format!("{:x}", f64::NAN.to_bits()) {
                return Err(format!("`{}` is not written", row.element_name(i)));
            }
        }
        Ok(())
    }

    fn check_indicators(&self, equations: ModelExchange<M>) -> Result<(), String> {
        let (Point(p, u), t) = (&self.start, M::INFO.experiment.start);
        let what = |error: ModelError| format!("event indicators with the start values: {error}");
        let model = M::initialize(p, u, t).map_err(what)?;
        let now = M::Evaluation::new(&model, p, u).map_err(what)?;
        let rows = equations.indicators;
        // Room for what a model writes without a row.
        let mut z = vec![f64::NAN; if rows.is_empty() { 16 } else { rows.len() }];
        (equations.indicate)(&model, p, u, &now, t, &mut z).map_err(what)?;
        if rows.is_empty() && z.iter().any(|z| !z.is_nan()) {
            return Err("`fn indicators` writes event indicators, but `const INDICATORS` has none, so their events are never found".to_owned());
        }
        match rows.iter().zip(&z).find(|(_, z)| z.is_nan()) {
            Some((row, _)) => Err(format!("event indicator `{}` is not written", row.name)),
            None => Ok(()),
        }
    }

    /// Compares the derivatives that only the model's solver uses with the inputs and states that
    /// they declare to depend on: it has its Jacobian from these.
    pub(super) fn compare_rates(&mut self, model: &M, point: &Point<M>) {
        let (Some(equations), None) = (M::EVENTS, M::MODEL_EXCHANGE) else {
            return;
        };
        let find = |name: &str| {
            let mut rows = self.layout.rows();
            let row = rows.find(|(_, row)| row.name == name && !row.storage.is_parameter())?;
            Some(((), row.0))
        };
        // Position of each state, and the row and index of its derivative.
        let mut states = Vec::new();
        for row in (equations.derivatives)() {
            let elements = find(row.name)
                .map_or(0..0, |((), elements)| elements)
                .enumerate();
            states.extend(elements.map(|(i, position)| (position, i, row)));
        }
        if states.is_empty() {
            return;
        }
        let rates = |model: &M, Point(p, u): &Point<M>| {
            let (now, mut rate) = (M::Evaluation::new(model, p, u).ok()?, model.clone());
            let mut dx = vec![0.0; states.len()];
            (equations.write_derivatives(model, (p, u, &now, 0.0), &mut rate, &mut dx)).ok()?;
            Some(dx)
        };
        let Some(expected) = rates(model, point) else {
            return;
        };
        let mut found = Vec::new();
        for (known, element) in self.layout.samples() {
            let state = states.iter().position(|state| state.0 == known);
            match state {
                Some(k) => {
                    let mut x = vec![0.0; states.len()];
                    (equations.states)(model, &mut x);
                    let size = element.1.nominal.unwrap_or(1.0).max(x[k].abs());
                    for part in [1e-3, 0.2, -3.0] {
                        let (mut model, mut x) = (model.clone(), x.clone());
                        x[k] += part * size;
                        (equations.set_states)(&mut model, &x);
                        found.extend(rates(&model, point).map(|dx| (known, dx)));
                    }
                }
                None if element.1.causality == Causality::Input => {
                    let moved = point.over_range(element);
                    let moved = moved.iter().filter_map(|point| rates(model, point));
                    found.extend(moved.map(|dx| (known, dx)));
                }
                None => {}
            }
        }
        let mut problems = Vec::new();
        for (known, dx) in &found {
            for (k, (_, i, row)) in states.iter().enumerate() {
                let Dependencies::Same(names) = row.dependencies else {
                    continue;
                };
                let is_declared = names.iter().any(|name| {
                    elements(name, *i, find).is_some_and(|((), range)| range.contains(known))
                });
                if !dx[k].is_same(&expected[k]) && !is_declared {
                    problems.push(format!(
                        "`{}` depends on `{}`, which it does not declare",
                        row.element_name(*i),
                        self.name(*known)
                    ));
                }
            }
        }
        self.problems.extend(problems);
    }

    /// A sample of the states: index, position and row.
    fn sampled_states(&self) -> Vec<(usize, usize, &'static Variable<M>)> {
        let state = |(position, (_, row)): (usize, Element<M>)| {
            let mut states = self.knowns.states.iter();
            let k = states.position(|&state| state == position)?;
            Some((k, position, row))
        };
        let samples = self.layout.samples().into_iter();
        samples.filter_map(state).collect()
    }

    /// Compares the model's directional derivatives with differences, for each state and input.
    fn compare_directional(&mut self, model: &M, point: &Point<M>) -> Result<(), ModelError> {
        let (Some(equations), n) = (M::MODEL_EXCHANGE, self.layout.states) else {
            return Ok(());
        };
        let mut point = point.clone();
        point.set_inputs();
        let Point(p, u) = &point;
        let look = |x: &[f64], u: &M::Input| -> Result<Vec<f64>, ModelError> {
            let (mut at, mut dx) = (model.clone(), vec![0.0; n]);
            (equations.set_states)(&mut at, x);
            let (now, mut rate) = (M::Evaluation::new(&at, p, u)?, at.clone());
            equations.write_derivatives(&at, (p, u, &now, 0.0), &mut rate, &mut dx)?;
            dx.extend(real_outputs::<M>(&at.output(p, u, &now)?));
            Ok(dx)
        };
        let (mut x, now) = (vec![0.0; n], M::Evaluation::new(model, p, u)?);
        (equations.states)(model, &mut x);
        let elements = self.layout.iter().enumerate();
        let derivatives = elements.filter(|(_, (_, row))| row.storage.is_derivative());
        let mut unknowns: Vec<_> = derivatives.map(|(k, _)| k).collect();
        unknowns.extend(self.real_outputs());
        for (known, element) in self.layout.samples() {
            let state = self.knowns.states.iter().position(|&state| state == known);
            let (mut dx, mut du) = (vec![0.0; n], zero::<M>(u));
            let value = match (state, &element.1.storage) {
                (Some(k), _) => {
                    dx[k] = 1.0;
                    x[k]
                }
                (None, Storage::RealIn(field)) => {
                    *field.get_mut(&mut du, element.0) = 1.0;
                    field.get(u, element.0)
                }
                _ => continue,
            };
            let Some(dy) = equations.directional_derivative(model, (p, u, &now, 0.0), &mut dx, &du)
            else {
                return Ok(());
            };
            dx.extend(real_outputs::<M>(&dy?));
            let size = element.1.nominal.unwrap_or(1.0).max(value.abs());
            self.compare_column(known, &unknowns, size, &dx, |by| {
                let mut x = x.clone();
                let u = match state {
                    Some(k) => {
                        x[k] += by;
                        u.clone()
                    }
                    None => shift_input::<M>(u, element, by)?,
                };
                look(&x, &u).ok()
            });
        }
        Ok(())
    }

    /// Compares outputs, derivatives and indicators with the declared dependencies on each state.
    pub(super) fn compare_states(&mut self, model: &M, point: &Point<M>) {
        let (Some(equations), Ok(expected)) =
            (M::MODEL_EXCHANGE, output(&self.layout, model, point))
        else {
            return;
        };
        if let Err(error) = self.compare_directional(model, point) {
            self.problems.insert(format!("directional: {error}"));
        }
        let mut x = vec![0.0; self.layout.states];
        (equations.states)(model, &mut x);
        for (k, known, row) in self.sampled_states() {
            for part in [1e-3, 0.2, -3.0] {
                let (mut model, mut moved) = (model.clone(), x.clone());
                moved[k] += part * row.nominal.unwrap_or(1.0).max(x[k].abs());
                (equations.set_states)(&mut model, &moved);
                if let Ok(found) = output(&self.layout, &model, point) {
                    self.compare(known, &expected, &found, false);
                }
            }
        }
    }
}
