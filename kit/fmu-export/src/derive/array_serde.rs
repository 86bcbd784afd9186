//! Serialization of arrays of any length as one flat tuple, because serde implements arrays only up
//! to 32 elements. The code that `fmu-export-derive` generates uses it.

use super::Choice;
use crate::Binary;
use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;

/// A value, or a nested array of values, that is serialized element by element.
pub trait ArrayCells: Sized {
    /// All values zero or empty.
    const ZERO: Self;
    /// The number of values.
    const LEN: usize;

    /// Writes the values.
    ///
    /// # Errors
    /// Those of the serializer.
    fn write<S: SerializeTuple>(&self, to: &mut S) -> Result<(), S::Error>;

    /// Reads the values.
    ///
    /// # Errors
    /// Those of the deserializer.
    fn read<'de, A: SeqAccess<'de>>(&mut self, from: &mut A) -> Result<(), A::Error>;
}

macro_rules! cells {
    ($([$($of:ident)?] $type:ty: $zero:expr;)*) => {$(
        impl$(<$of>)? ArrayCells for $type {
            const ZERO: Self = $zero;
            const LEN: usize = 1;

            fn write<S: SerializeTuple>(&self, to: &mut S) -> Result<(), S::Error> {
                to.serialize_element(self)
            }

            fn read<'de, A: SeqAccess<'de>>(&mut self, from: &mut A) -> Result<(), A::Error> {
                let next = from.next_element()?;
                *self = next.ok_or_else(|| A::Error::custom("an array is too short"))?;
                Ok(())
            }
        }
    )*};
}

cells! {
    [] f64: 0.0; [] f32: 0.0; [] bool: false; [] String: String::new(); [] Binary: Binary::new();
    [] i8: 0; [] u8: 0; [] i16: 0; [] u16: 0; [] i32: 0; [] u32: 0; [] i64: 0; [] u64: 0;
    [E] Choice<E>: Choice::NONE;
}

impl<T: ArrayCells, const N: usize> ArrayCells for [T; N] {
    const ZERO: Self = [T::ZERO; N];
    const LEN: usize = N * T::LEN;

    fn write<S: SerializeTuple>(&self, to: &mut S) -> Result<(), S::Error> {
        self.iter().try_for_each(|cell| cell.write(to))
    }

    fn read<'de, A: SeqAccess<'de>>(&mut self, from: &mut A) -> Result<(), A::Error> {
        self.iter_mut().try_for_each(|cell| cell.read(from))
    }
}

/// An array to serialize.
pub struct SerializedArray<'a, T>(pub &'a T);

impl<T: ArrayCells> Serialize for SerializedArray<'_, T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut tuple = to.serialize_tuple(T::LEN)?;
        self.0.write(&mut tuple)?;
        tuple.end()
    }
}

/// An array to deserialize.
pub struct DeserializedArray<T>(pub T);

impl<'de, T: ArrayCells> Deserialize<'de> for DeserializedArray<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Elements<T>(PhantomData<T>);

        impl<'de, T: ArrayCells> Visitor<'de> for Elements<T> {
            type Value = DeserializedArray<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{} values", T::LEN)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<Self::Value, A::Error> {
                let mut read = DeserializedArray(T::ZERO);
                read.0.read(&mut from)?;
                Ok(read)
            }
        }

        from.deserialize_tuple(T::LEN, Elements(PhantomData))
    }
}
