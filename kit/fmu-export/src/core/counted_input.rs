//! Inputs that count how often they were set, for models (emla, controller, rig) that react to each
//! set of an input, even to its present value, and extrapolate it in between.

use serde::{Deserialize, Serialize};

/// An input that counts its sets. Its row is `row!(V, counted_input x, "…")`, or a row with
/// [`counted`](crate::Variable::counted)`(|u| &mut u.x.sets)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CountedInput<T> {
    /// The value set last, or the start value.
    pub value: T,
    /// How often it was set; the count wraps around.
    pub sets: u32,
}

impl<T: Copy> CountedInput<T> {
    /// An input with a start value that was not set yet.
    pub const fn new(value: T) -> Self {
        Self { value, sets: 0 }
    }

    /// The value, if the importer has set it.
    #[inline]
    pub fn if_set(&self) -> Option<T> {
        (self.sets > 0).then_some(self.value)
    }
}

/// A value in a model's state that follows a [`CountedInput`] when it is set, and that the model
/// extrapolates until it is set again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExtrapolatedInput<T> {
    /// How often the input had been set when `value` was computed.
    sets: u32,
    /// The value until the input is set again.
    value: T,
}

impl<T: Copy> ExtrapolatedInput<T> {
    /// Starts from the input's value.
    pub fn from_input(input: &CountedInput<T>) -> Self {
        Self::with_value(input, input.value)
    }

    /// The value to which the model has extrapolated the input.
    pub fn with_value(input: &CountedInput<T>, value: T) -> Self {
        let sets = input.sets;
        Self { sets, value }
    }

    /// The extrapolated value, even if the input was set since.
    #[inline]
    pub fn value(&self) -> T {
        self.value
    }

    /// The present value: that of the input if it was set since, else the extrapolated one.
    #[inline]
    pub fn now(&self, input: &CountedInput<T>) -> T {
        if input.sets == self.sets {
            self.value
        } else {
            input.value
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_carried_until_it_is_set_again() {
        let mut x = CountedInput::new(0.3);
        assert_eq!(x.if_set(), None);
        let mut rod = ExtrapolatedInput::from_input(&x);
        assert_eq!(rod.now(&x), 0.3);
        rod = ExtrapolatedInput::with_value(&x, 0.4);
        assert_eq!((rod.now(&x), rod.value()), (0.4, 0.4));
        x.sets += 1; // set to what it is
        assert_eq!((rod.now(&x), rod.value()), (0.3, 0.4));
        assert_eq!(x.if_set(), Some(0.3));
    }
}
