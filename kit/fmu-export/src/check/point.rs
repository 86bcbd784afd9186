//! Parameters and inputs at which `check` runs the model, and small changes of them.

use crate::Model;
use crate::core::layout::Element;
use crate::core::model::Variable;
use crate::core::storage::{Values, ValuesMut, each};
use crate::core::value::Value;

/// Parameters and inputs.
#[derive(Clone)]
pub(super) struct Point<M: Model>(pub(super) M::Parameters, pub(super) M::Input);

impl<M: Model> Point<M> {
    /// The values of an input or a parameter.
    pub(super) fn values(&self, row: &Variable<M>) -> Option<Values<'_>> {
        let of_input = row.storage.input_values(&self.1);
        of_input.or_else(|| row.storage.parameter_values(&self.0))
    }

    pub(super) fn values_mut(&mut self, row: &Variable<M>) -> Option<ValuesMut<'_>> {
        let of_input = row.storage.input_values_mut(&mut self.1);
        of_input.or_else(|| row.storage.parameter_values_mut(&mut self.0))
    }

    /// The value of an element as text: equal texts mean equal bits.
    pub(super) fn read(&self, (i, row): Element<M>) -> Option<String> {
        Some(each!(Values, self.values(row)?, |values| values[i].to_string()))
    }

    /// Counts a set of each input to its present value.
    pub(super) fn set_inputs(&mut self) {
        for counter in M::variables().iter().filter_map(|row| row.counter) {
            let count = counter(&mut self.1);
            *count = count.wrapping_add(1);
        }
    }

    /// The points at which an element has its other values over its range.
    pub(super) fn over_range(&self, (i, row): Element<M>) -> Vec<Self> {
        let mut points = Vec::new();
        for k in 0.. {
            let mut point = self.clone();
            let Some(values) = point.values_mut(row).filter(|_| !row.structural) else {
                break;
            };
            let is_other = each!(ValuesMut, values, |values| {
                let Some(other) = values[i].over_range(row).into_iter().nth(k) else {
                    break;
                };
                let is_other = !values[i].is_same(&other) && other.is_allowed(row);
                values[i] = other;
                is_other
            });
            points.extend(is_other.then_some(point));
        }
        points
    }

    /// Changes an element by a fraction of its magnitude to another allowed value, if any.
    pub(super) fn perturb(&mut self, (i, row): Element<M>, part: f64) -> bool {
        if row.structural {
            return false; // it would change the table
        }
        let Some(values) = self.values_mut(row) else {
            return false;
        };
        each!(ValuesMut, values, |values| {
            let moved = values[i].perturbed(part, row);
            let is_other = |v: &_| !values[i].is_same(v) && v.is_allowed(row);
            match moved.into_iter().find(is_other) {
                Some(other) => values[i] = other,
                None => return false,
            }
        });
        true
    }
}
