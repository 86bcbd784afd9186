//! Inputs that count how often they were set, for models to which setting one means something, if
//! only to the value that it has.

use serde::{Deserialize, Serialize};

/// An input that counts its sets: the row is `row!(V, counted_input x, "…")`, or says
/// [`counted`](crate::Variable::counted)`(|u| &mut u.x.sets)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CountedInput<T> {
    /// What the importer has set, or the start value.
    pub value: T,
    /// How often it was set; the count wraps around.
    pub sets: u32,
}

impl<T: Copy> CountedInput<T> {
    /// An input with a start value, which nobody has set yet.
    pub const fn new(value: T) -> Self {
        Self { value, sets: 0 }
    }

    /// The value once the importer has set it.
    #[inline]
    pub fn if_set(&self) -> Option<T> {
        (self.sets > 0).then_some(self.value)
    }
}

/// Part of a model's state: a value that the importer sets by an input from time to time, and that
/// the model moves on in between.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExtrapolatedInput<T> {
    /// How often the input had been set.
    sets: u32,
    /// The value until it is set again.
    value: T,
}

impl<T: Copy> ExtrapolatedInput<T> {
    /// The value that the input has.
    pub fn from_input(input: &CountedInput<T>) -> Self {
        Self::with_value(input, input.value)
    }

    /// The value that the model has moved it to since the input was set.
    pub fn with_value(input: &CountedInput<T>, value: T) -> Self {
        let sets = input.sets;
        Self { sets, value }
    }

    /// Where the model has moved it, whatever the input says.
    #[inline]
    pub fn value(&self) -> T {
        self.value
    }

    /// The value now: the input's if it has been set since.
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
