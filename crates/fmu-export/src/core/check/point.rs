//! Parameters and inputs at which a model is tried.

use crate::Model;
use crate::core::layout::Element;
use crate::core::value::Value;

/// Runs `$then` with the place of an input or a parameter, and where it lives in a [`Point`].
macro_rules! known {
    ($row:expr, $point:expr, |$place:ident, $owner:ident| $then:expr) => {
        crate::core::place::input!(&$row.place, |$place| {
            let $owner = $point.u();
            $then
        })
        .or_else(|| {
            crate::core::place::parameter!(&$row.place, |$place| {
                let $owner = $point.p();
                $then
            })
        })
    };
}

pub(super) use known;

/// Parameters and inputs.
pub(super) struct Point<M: Model>(pub(super) M::Parameters, pub(super) M::Input);

impl<M: Model> Clone for Point<M> {
    fn clone(&self) -> Self {
        Self(self.0.clone(), self.1.clone())
    }
}

impl<M: Model> Point<M> {
    pub(super) fn p(&mut self) -> &mut M::Parameters {
        &mut self.0
    }

    pub(super) fn u(&mut self) -> &mut M::Input {
        &mut self.1
    }

    /// The value in an element, as text: equal texts are equal bits.
    pub(super) fn read(&mut self, (i, row): Element<M>) -> Option<String> {
        known!(row, self, |place, owner| place.get(owner, i).to_string())
    }

    /// Counts that all inputs are set, to what they are.
    pub(super) fn set_inputs(&mut self) {
        for counter in M::variables().iter().filter_map(|row| row.counter) {
            let count = counter(&mut self.1);
            *count = count.wrapping_add(1);
        }
    }

    /// Moves an element by a part of its size, to another value that is allowed; false if there is
    /// none.
    pub(super) fn perturb(&mut self, (i, row): Element<M>, part: f64) -> bool {
        if row.structural {
            return false; // the table would be another one
        }
        known!(row, self, |place, owner| {
            let value = place.get(owner, i);
            let moved = value.moved(part, row);
            let other = moved
                .into_iter()
                .find(|v| !v.is_same(&value) && v.is_allowed(row));
            let is_moved = other.is_some();
            if let Some(other) = other {
                *place.get_mut(owner, i) = other;
            }
            is_moved
        })
        .unwrap_or(false)
    }
}
