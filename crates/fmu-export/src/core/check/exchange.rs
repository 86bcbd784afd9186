//! Derivatives and event indicators: that they are all written, of the states that the table shows,
//! and follow what they declare.

use super::point::Point;
use super::trial::{Trial, output};
use crate::core::continuous::ModelExchange;
use crate::core::layout::Layout;
use crate::core::place::Place;
use crate::core::value::Value;
use crate::{Evaluation, Model, ModelError};

/// Writes derivatives and indicators as texts where their elements are among all.
pub(super) fn behind<M: Model>(
    layout: &Layout<M>,
    model: &M,
    Point(p, u): &Point<M>,
    now: &M::Evaluation,
    texts: &mut [String],
) -> Result<(), ModelError> {
    let Some(equations) = M::MODEL_EXCHANGE else {
        return Ok(());
    };
    let mut rate = model.clone();
    let mut numbers = vec![f64::NAN; layout.states + layout.indicators];
    let (dx, z) = numbers.split_at_mut(layout.states);
    (equations.set_states)(&mut rate, dx);
    (equations.differentiate)(model, p, u, now, 0.0, &mut rate)?;
    (equations.states)(&rate, dx);
    (equations.indicate)(model, p, u, now, 0.0, z)?;
    let places = layout
        .iter()
        .zip(texts)
        .filter(|((_, row), _)| row.place.is_behind());
    for ((_, text), number) in places.zip(&numbers) {
        *text = format!("{:x}", number.to_bits());
    }
    Ok(())
}

impl<M: Model> Trial<M> {
    /// States are what the table shows, and derivatives are all written.
    pub(super) fn exchange(&mut self) {
        if let Some(equations) = M::MODEL_EXCHANGE
            && let Err(problem) = self.exchanged(equations)
        {
            self.problems.insert(problem);
        }
    }

    fn exchanged(&self, equations: ModelExchange<M>) -> Result<(), String> {
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
        let now = M::Evaluation::of(&model, p, u).map_err(what)?;
        let y = model.output(p, u, &now).map_err(what)?;
        let texts = output(&self.layout, &model, &self.start).map_err(what)?;
        let states = self.knowns.states.iter().zip(
            self.layout
                .iter()
                .zip(&texts)
                .filter(|((_, row), _)| row.place.is_derivative()),
        );
        for (k, (&state, ((i, row), text))) in states.enumerate() {
            let name = self.name(state);
            let (_, shown) = self.layout.iter().nth(state).expect("counted");
            if let Place::RealOut(place) = &shown.place
                && !(moved[k].is_same(x[k]) && place.get(&y, i).is_same(x[k]))
            {
                return Err(format!(
                    "state {k} was set to {}, but `states` gives {}, and `{name}` is {}",
                    x[k],
                    moved[k],
                    place.get(&y, i)
                ));
            }
            if *text == format!("{:x}", f64::NAN.to_bits()) {
                return Err(format!("`{}` is not written", row.element_name(i)));
            }
        }
        Ok(())
    }

    /// Outputs, derivatives and indicators against each state, at one point.
    pub(super) fn compare_states(&mut self, model: &M, point: &Point<M>) {
        let (Some(equations), Ok(expected)) =
            (M::MODEL_EXCHANGE, output(&self.layout, model, point))
        else {
            return;
        };
        let mut x = vec![0.0; self.layout.states];
        (equations.states)(model, &mut x);
        for (k, known) in self.knowns.states.clone().into_iter().enumerate() {
            for part in [1e-3, 0.2] {
                let (mut model, mut moved) = (model.clone(), x.clone());
                let (_, row) = self.layout.iter().nth(known).expect("counted");
                moved[k] += part * row.nominal.unwrap_or(1.0).max(x[k].abs());
                (equations.set_states)(&mut model, &moved);
                if let Ok(found) = output(&self.layout, &model, point) {
                    self.compare(known, &expected, &found, false);
                }
            }
        }
    }
}
