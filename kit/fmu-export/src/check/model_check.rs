//! The state of a check: the model's table, its start values, and the problems found so far. The
//! modules of `check` with tests add their methods to this type.

use super::point::Point;
use crate::core::dependencies::Knowns;
use crate::core::layout::{Element, Layout};
use crate::core::sizes::fit_start_values;
use crate::core::storage::{Storage, each};
use crate::core::value::Value;
use crate::{Evaluation, Model, ModelError};
use std::collections::BTreeSet;

/// A check in progress.
pub(super) struct ModelCheck<M: Model> {
    pub(super) layout: Layout<M>,
    pub(super) knowns: Knowns,
    pub(super) start: Point<M>,
    pub(super) problems: BTreeSet<String>,
}

impl<M: Model> ModelCheck<M> {
    pub(super) fn new() -> Self {
        let (p, u) = fit_start_values::<M>(M::defaults());
        let layout = Layout::new(&p, &u);
        Self {
            knowns: Knowns::new(&layout),
            layout,
            start: Point(p, u),
            problems: BTreeSet::new(),
        }
    }

    pub(super) fn name(&self, element: usize) -> String {
        let (i, row) = self.layout.iter().nth(element).expect("counted");
        row.element_name(i)
    }

    /// Reports that two elements share a field.
    pub(super) fn share_a_field(&mut self, a: usize, b: usize) {
        let [first, second] = [a.min(b), a.max(b)].map(|k| self.name(k));
        let problem = format!("`{first}` and `{second}` share a field");
        self.problems.insert(problem);
    }

    /// Reports that the accessors of an element are of different fields.
    pub(super) fn has_two_fields(&mut self, k: usize) {
        let problem = format!("`{}`: its accessors are of different fields", self.name(k));
        self.problems.insert(problem);
    }
}

/// All outputs, derivatives and event indicators as texts, by element.
pub(super) fn output<M: Model>(
    layout: &Layout<M>,
    model: &M,
    point: &Point<M>,
) -> Result<Vec<String>, ModelError> {
    let now = M::Evaluation::new(model, &point.0, &point.1)?;
    let mut texts = texts(layout, &model.output(&point.0, &point.1, &now)?);
    write_equations(layout, model, point, &now, &mut texts)?;
    Ok(texts)
}

pub(super) fn texts<M: Model>(layout: &Layout<M>, y: &M::Output) -> Vec<String> {
    let text = |(i, row): Element<M>| match &row.storage {
        Storage::RealOut(field) => format!("{:x}", field.get(y, i).to_bits()),
        Storage::TextOut(get) => get(y).to_owned(),
        storage => (storage.output_values(y)).map_or(String::new(), |values| {
            each!(Values, values, |values| values[i].to_xml())
        }),
    };
    layout.iter().map(text).collect()
}

/// Writes derivatives and event indicators as texts into their elements.
fn write_equations<M: Model>(
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
    (equations.set_states)(&mut rate, &numbers[..layout.states]);
    let at = (p, u, now, 0.0);
    equations.derivatives_and_indicators(model, at, &mut rate, layout.states, &mut numbers)?;
    let elements = layout.iter().zip(texts);
    let rows = elements.filter(|((_, row), _)| row.storage.is_equation());
    for ((_, text), number) in rows.zip(&numbers) {
        *text = format!("{:x}", number.to_bits());
    }
    Ok(())
}
