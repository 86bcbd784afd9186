//! Inputs that count how often they were set, for models to which setting one means something, if
//! only to the value that it has.

use serde::{Deserialize, Serialize};

/// An input that counts its sets: the row is `row!(V, counted_input x, "…")`, or says
/// [`counted`](crate::Variable::counted)`(|u| &mut u.x.sets)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counted<T> {
    /// What the importer has set, or the start value.
    pub value: T,
    /// How often it was set; the count wraps around.
    pub sets: u32,
}

impl<T: Copy> Counted<T> {
    /// An input with a start value, which nobody has set yet.
    pub const fn unset(value: T) -> Self {
        Self { value, sets: 0 }
    }

    /// The value once the importer has set it.
    #[inline]
    pub fn told(&self) -> Option<T> {
        (self.sets > 0).then_some(self.value)
    }
}

/// Part of a model's state: a value that the importer sets by an input from time to time, and that
/// the model moves on in between.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Carried<T> {
    /// How often the input had been set.
    sets: u32,
    /// The value until it is set again.
    value: T,
}

impl<T: Copy> Carried<T> {
    /// The value that the input has.
    pub fn at(input: &Counted<T>) -> Self {
        Self::moved(input, input.value)
    }

    /// The value that the model has moved it to since the input was set.
    pub fn moved(input: &Counted<T>, value: T) -> Self {
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
    pub fn now(&self, input: &Counted<T>) -> T {
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
        let mut x = Counted::unset(0.3);
        assert_eq!(x.told(), None);
        let mut rod = Carried::at(&x);
        assert_eq!(rod.now(&x), 0.3);
        rod = Carried::moved(&x, 0.4);
        assert_eq!((rod.now(&x), rod.value()), (0.4, 0.4));
        x.sets += 1; // set to what it is
        assert_eq!((rod.now(&x), rod.value()), (0.3, 0.4));
        assert_eq!(x.told(), Some(0.3));
    }
}
