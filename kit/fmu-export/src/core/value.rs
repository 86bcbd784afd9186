//! [`Value`]: what every type of variable implements (bounds checks, comparison by bits, texts for
//! messages and XML), for access to variables, model descriptions and `check`.

use super::binary::Binary;
use super::enumeration::numbered;
use super::model::{Model, Variable};
use super::storage::StorageType;
use std::fmt::Display;

/// A type of variable.
pub(crate) trait Value: StorageType + Clone + Default + Display + 'static {
    /// Whether the value is finite, in the row's bounds and in its enumeration.
    #[inline]
    fn is_allowed<M: Model>(&self, row: &Variable<M>) -> bool {
        self.is_within(row.bounds())
    }

    /// The same with [`Variable::bounds`] of the row.
    fn is_within(&self, bounds: [f64; 2]) -> bool;

    /// Whether the two are the same bits.
    fn is_same(&self, other: &Self) -> bool;

    /// Appends its bytes, which differ for different values.
    fn write_bytes(&self, to: &mut Vec<u8>);

    /// Text for the model description; the shortest that reads back as the same number.
    fn to_xml(&self) -> String {
        self.to_string()
    }

    /// Text for a message.
    #[cold]
    fn to_message(&self) -> String {
        self.to_string()
    }

    /// Nearby values, changed by a fraction of its magnitude; some of them may not be allowed.
    fn perturbed<M: Model>(&self, part: f64, row: &Variable<M>) -> Vec<Self>;

    /// Values over the whole range of a row, for modes that small changes never reach; some of them
    /// may not be allowed.
    fn over_range<M: Model>(&self, row: &Variable<M>) -> Vec<Self> {
        self.perturbed(0.2, row)
    }

    /// The bits of a number, sign-extended to 64 bits if it is an integer; 0 for other types.
    fn bits(&self) -> u64 {
        0
    }

    /// The number with these bits.
    fn from_raw_bits(_bits: u64) -> Self {
        Self::default()
    }

    /// These numbers, if the type is `f64`.
    fn from_reals(_values: &[f64]) -> Option<&[Self]> {
        None
    }

    /// Whether the type has this finite number, for bounds.
    fn holds(x: f64) -> bool {
        x.fract() == 0.0
    }

    /// Whether the value is neither NaN nor infinite.
    fn is_finite(&self) -> bool {
        true
    }

    /// Whether all values are finite.
    #[inline]
    fn are_finite(values: &[Self]) -> bool {
        values.iter().all(Value::is_finite)
    }
}

/// Methods that are the same for all floating-point types.
macro_rules! float {
    () => {
        #[inline]
        fn is_same(&self, other: &Self) -> bool {
            self.to_bits() == other.to_bits()
        }

        fn write_bytes(&self, to: &mut Vec<u8>) {
            to.extend(self.to_le_bytes());
        }

        fn holds(x: f64) -> bool {
            (x as Self).is_finite()
        }

        fn to_xml(&self) -> String {
            format!("{self:?}")
        }

        fn perturbed<M: Model>(&self, part: f64, row: &Variable<M>) -> Vec<Self> {
            let size = row.nominal.unwrap_or(1.0).max(self.abs().into());
            let sizes = [1.0, 0.1, 1e-3].into_iter();
            let parts = sizes.flat_map(|of| [of * part, -of * part]);
            parts.map(|part| self + (part * size) as Self).collect()
        }

        fn over_range<M: Model>(&self, row: &Variable<M>) -> Vec<Self> {
            let size = row.nominal.unwrap_or(1.0).max(self.abs().into());
            let away = [-3.0, 3.0].map(|part| self + (part * size) as Self);
            let ends = [row.min, row.max, 0.5 * (row.min + row.max)].map(|x| x as Self);
            [away, [-self, 0.0]]
                .concat()
                .into_iter()
                .chain(ends)
                .filter(|x| x.is_finite())
                .collect()
        }

        #[inline]
        fn is_finite(&self) -> bool {
            self.abs() <= Self::MAX // one comparison, which NaN fails too
        }
    };
}

impl Value for f64 {
    float!();

    #[inline]
    fn is_within(&self, [min, max]: [f64; 2]) -> bool {
        min <= *self && *self <= max
    }

    fn from_reals(values: &[f64]) -> Option<&[f64]> {
        Some(values)
    }

    /// Without a branch for each value: in a value that is not finite all bits of the exponent are
    /// set, and adding one to it carries into the sign.
    #[inline]
    fn are_finite(values: &[f64]) -> bool {
        const SIGN: u64 = 1 << 63;
        const LAST_OF_EXPONENT: u64 = 1 << (f64::MANTISSA_DIGITS - 1);
        let carry = |value: &f64| (value.to_bits() & !SIGN) + LAST_OF_EXPONENT;
        values.iter().fold(0, |all, value| all | carry(value)) < SIGN
    }
}

impl Value for f32 {
    float!();

    fn bits(&self) -> u64 {
        self.to_bits().into()
    }

    fn from_raw_bits(bits: u64) -> f32 {
        f32::from_bits(bits as u32)
    }

    /// Bounds are written with fewer digits than an f64 has: the nearest f32 is meant.
    #[inline]
    fn is_within(&self, [min, max]: [f64; 2]) -> bool {
        self.is_finite() && min as f32 <= *self && *self <= max as f32
    }
}

/// Implements [`Value`] for integers.
macro_rules! integer {
    ($($type:ty)*) => {$(
        impl Value for $type {
            /// Bounds are whole numbers of the type, or infinite.
            #[inline]
            fn is_within(&self, [min, max]: [f64; 2]) -> bool {
                min as Self <= *self && *self <= max as Self
            }

            #[inline]
            fn is_same(&self, other: &Self) -> bool {
                self == other
            }

            fn write_bytes(&self, to: &mut Vec<u8>) {
                to.extend(self.to_le_bytes());
            }

            fn holds(x: f64) -> bool {
                let all = i128::from(Self::MIN)..=i128::from(Self::MAX);
                x.fract() == 0.0 && all.contains(&(x as i128))
            }

            fn perturbed<M: Model>(&self, _part: f64, _row: &Variable<M>) -> Vec<Self> {
                vec![self.saturating_add(1), self.saturating_sub(1)]
            }

            fn over_range<M: Model>(&self, row: &Variable<M>) -> Vec<Self> {
                // Of an enumeration all items, from 1.
                let items = row.enumeration.map_or(0, |e| e.items.len()).min(64);
                let ends = [row.min, row.max].into_iter().filter(|x| x.is_finite());
                let ends = ends.map(|x| x as Self);
                (1..=items as Self).chain(ends).chain([0, self.saturating_add(3)]).collect()
            }

            fn bits(&self) -> u64 {
                *self as u64
            }

            fn from_raw_bits(bits: u64) -> Self {
                bits as Self
            }
        }
    )*};
}

integer! { i8 u8 i16 u16 i32 u32 i64 u64 }

impl Value for bool {
    #[inline]
    fn is_within(&self, _bounds: [f64; 2]) -> bool {
        true
    }

    #[inline]
    fn is_same(&self, other: &bool) -> bool {
        self == other
    }

    fn write_bytes(&self, to: &mut Vec<u8>) {
        to.push((*self).into());
    }

    fn perturbed<M: Model>(&self, _part: f64, _row: &Variable<M>) -> Vec<bool> {
        vec![!self]
    }

    fn bits(&self) -> u64 {
        (*self).into()
    }

    fn from_raw_bits(bits: u64) -> bool {
        bits != 0
    }
}

impl Value for String {
    fn is_within(&self, _bounds: [f64; 2]) -> bool {
        true
    }

    fn is_same(&self, other: &String) -> bool {
        self == other
    }

    fn write_bytes(&self, to: &mut Vec<u8>) {
        to.extend((self.len() as u64).to_le_bytes());
        to.extend(self.as_bytes());
    }

    fn to_message(&self) -> String {
        format!("\"{self}\"")
    }

    fn perturbed<M: Model>(&self, _part: f64, _row: &Variable<M>) -> Vec<String> {
        vec![format!("{self}'")]
    }
}

impl Value for Binary {
    fn is_within(&self, _bounds: [f64; 2]) -> bool {
        true
    }

    fn is_same(&self, other: &Binary) -> bool {
        self == other
    }

    fn write_bytes(&self, to: &mut Vec<u8>) {
        to.extend((self.len() as u64).to_le_bytes());
        to.extend(&self.0);
    }

    fn perturbed<M: Model>(&self, _part: f64, _row: &Variable<M>) -> Vec<Binary> {
        vec![Binary([&self[..], &[0]].concat())]
    }
}

/// The allowed values of a row, for messages: `1 (motion) or 2 (force)`, `from 0 to 1`.
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
