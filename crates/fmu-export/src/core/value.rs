//! The three types with fixed size: Real, Integer (and Enumeration), Boolean.

use super::enumeration::numbered;
use super::model::{Model, Variable};
use super::place::{Kind, Place, Read, Write};
use std::fmt::Display;

/// A type of variable: where rows keep it, what is allowed.
pub(crate) trait Value: Copy + Default + Display + 'static {
    const KIND: Kind;

    fn input<P, U, Y>(place: &Place<P, U, Y>) -> Option<&Write<U, Self>>;
    fn parameter<P, U, Y>(place: &Place<P, U, Y>) -> Option<&Write<P, Self>>;
    fn output<P, U, Y>(place: &Place<P, U, Y>) -> Option<&Read<Y, Self>>;

    /// Whether the value is finite, in the row's bounds and in its enumeration.
    #[inline]
    fn is_allowed<M: Model>(self, row: &Variable<M>) -> bool {
        self.is_within(row.bounds())
    }

    /// The same with [`Variable::bounds`] of the row.
    fn is_within(self, bounds: [f64; 2]) -> bool;

    /// Whether the two are the same bits.
    fn is_same(self, other: Self) -> bool;

    /// The value of time, if it is of this type.
    fn of_time(_time: f64) -> Option<Self> {
        None
    }

    /// These numbers, if they are of this type.
    fn of_reals(_values: &[f64]) -> Option<&[Self]> {
        None
    }

    /// Whether the value may be given out: no NaN, no infinity.
    fn is_finite(self) -> bool {
        true
    }

    /// The same of all of them.
    #[inline]
    fn are_finite(values: &[Self]) -> bool {
        values.iter().all(|value| value.is_finite())
    }
}

macro_rules! places {
    ($input:ident $parameter:ident $output:ident) => {
        #[inline]
        fn input<P, U, Y>(place: &Place<P, U, Y>) -> Option<&Write<U, Self>> {
            if let Place::$input(place) = place {
                Some(place)
            } else {
                None
            }
        }

        #[inline]
        fn parameter<P, U, Y>(place: &Place<P, U, Y>) -> Option<&Write<P, Self>> {
            if let Place::$parameter(place) = place {
                Some(place)
            } else {
                None
            }
        }

        #[inline]
        fn output<P, U, Y>(place: &Place<P, U, Y>) -> Option<&Read<Y, Self>> {
            if let Place::$output(place) = place {
                Some(place)
            } else {
                None
            }
        }
    };
}

impl Value for f64 {
    const KIND: Kind = Kind::Real;
    places!(RealIn RealParameter RealOut);

    #[inline]
    fn is_within(self, [min, max]: [f64; 2]) -> bool {
        min <= self && self <= max
    }

    #[inline]
    fn is_same(self, other: f64) -> bool {
        self.to_bits() == other.to_bits()
    }

    fn of_time(time: f64) -> Option<f64> {
        Some(time)
    }

    fn of_reals(values: &[f64]) -> Option<&[f64]> {
        Some(values)
    }

    #[inline]
    fn is_finite(self) -> bool {
        self.abs() <= f64::MAX // one comparison, which NaN fails too
    }

    /// Without a branch for each: of what is not finite all bits of the exponent are set, and one
    /// more carries into the sign.
    #[inline]
    fn are_finite(values: &[f64]) -> bool {
        const SIGN: u64 = 1 << 63;
        const LAST_OF_EXPONENT: u64 = 1 << (f64::MANTISSA_DIGITS - 1);
        let carry = |value: &f64| (value.to_bits() & !SIGN) + LAST_OF_EXPONENT;
        values.iter().fold(0, |all, value| all | carry(value)) < SIGN
    }
}

impl Value for i32 {
    const KIND: Kind = Kind::Integer;
    places!(IntegerIn IntegerParameter IntegerOut);

    #[inline]
    fn is_within(self, bounds: [f64; 2]) -> bool {
        f64::from(self).is_within(bounds)
    }

    #[inline]
    fn is_same(self, other: i32) -> bool {
        self == other
    }
}

impl Value for bool {
    const KIND: Kind = Kind::Boolean;
    places!(BooleanIn BooleanParameter BooleanOut);

    #[inline]
    fn is_within(self, _bounds: [f64; 2]) -> bool {
        true
    }

    #[inline]
    fn is_same(self, other: bool) -> bool {
        self == other
    }
}

/// What a value of the row must be, in words: `1 (motion) or 2 (force)`, `from 0 to 1`.
pub(crate) fn allowed<M: Model>(row: &Variable<M>) -> String {
    if let Some(enumeration) = row.enumeration {
        return numbered(enumeration.items);
    }
    match (row.min.is_finite(), row.max.is_finite()) {
        (true, true) => format!("from {} to {}", row.min, row.max),
        (true, false) => format!("finite and at least {}", row.min),
        (false, true) => format!("finite and at most {}", row.max),
        (false, false) => "finite".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::Value;

    #[test]
    fn what_is_not_finite_is_found_among_others() {
        let finite = [
            0.0,
            -0.0,
            1.5,
            f64::MAX,
            f64::MIN,
            f64::MIN_POSITIVE,
            -5e-324,
        ];
        for n in 0..=finite.len() {
            assert!(f64::are_finite(&finite[..n]));
            for wrong in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                for k in 0..n {
                    let mut values = finite;
                    values[k] = wrong;
                    assert!(!f64::are_finite(&values[..n]), "{wrong} at {k} of {n}");
                }
            }
        }
    }
}
