//! For the code that derives generate: makes the compiler report a missing derive on a field's
//! struct once, and not for each trait that the generated code needs.
//!
//! One place requires the struct's derive. All other generated code uses [`FieldType`], whose
//! functions are those of the type if it implements the trait, and otherwise those of [`Fallback`],
//! which compile but are never called.

use super::{Choice, Input, Item, Output, Parameters, Part, Rows, StatePart, Vector};
use crate::Model;
use serde::{Serialize, de::DeserializeOwned};
use std::marker::PhantomData;

/// The type of a field.
pub struct FieldType<T>(PhantomData<T>);

/// The rows of the type of a field, where the path `At` leads to it.
pub struct FieldRows<T, M, At>(PhantomData<(T, M, At)>);

impl<T: Clone> FieldType<T> {
    #[inline]
    pub fn copied(value: &T) -> T {
        value.clone()
    }

    #[inline]
    pub fn copied_to(from: &T, to: &mut T) {
        to.clone_from(from);
    }
}

impl<T: Default> FieldType<T> {
    #[inline]
    pub fn zero() -> T {
        T::default()
    }
}

impl<T: Serialize> FieldType<T> {
    pub fn written(value: &T) -> &T {
        value
    }
}

impl<T: DeserializeOwned> FieldType<T> {
    pub fn read(value: T) -> T {
        value
    }
}

impl<T: Parameters> FieldType<T> {
    pub fn start_parameters() -> T {
        T::start()
    }
}

impl<T: Input> FieldType<T> {
    pub fn start_input() -> T {
        T::start()
    }
}

impl<T: Vector> FieldType<T> {
    pub fn len(value: &T) -> usize {
        value.len()
    }

    #[inline]
    pub fn read_states<'a>(value: &T, to: &'a mut [f64]) -> &'a mut [f64] {
        value.read(to)
    }

    #[inline]
    pub fn write_states<'a>(value: &mut T, from: &'a [f64]) -> &'a [f64] {
        value.write(from)
    }

    pub fn not_finite(value: &T) -> Option<(&'static str, f64)> {
        value.not_finite()
    }
}

impl<E: Item> FieldType<Choice<E>> {
    pub fn choice(item: impl Into<Choice<E>>) -> Choice<E> {
        item.into()
    }

    #[inline]
    pub fn numbers(choices: &[Choice<E>]) -> &[i32] {
        Choice::numbers(choices)
    }

    #[inline]
    pub fn numbers_mut(choices: &mut [Choice<E>]) -> &mut [i32] {
        Choice::numbers_mut(choices)
    }
}

impl<T: Rows<M, At>, M: Model, At> FieldRows<T, M, At> {
    pub const ROWS: &'static [Part<M>] = T::ROWS;
}

/// Replaces the functions whose traits a type does not implement.
pub trait Fallback<T>: Sized {
    fn copied(_: &T) -> T {
        unreachable!()
    }

    fn copied_to(_: &T, _: &mut T) {}

    fn zero() -> T {
        unreachable!()
    }

    fn start_parameters() -> T {
        unreachable!()
    }

    fn start_input() -> T {
        unreachable!()
    }

    fn written(_: &T) {}

    fn read((): ()) -> T {
        unreachable!()
    }

    fn len(_: &T) -> usize {
        0
    }

    fn read_states<'a>(_: &T, to: &'a mut [f64]) -> &'a mut [f64] {
        to
    }

    fn write_states<'a>(_: &mut T, from: &'a [f64]) -> &'a [f64] {
        from
    }

    fn not_finite(_: &T) -> Option<(&'static str, f64)> {
        None
    }

    fn choice<X>(_: X) -> T {
        unreachable!()
    }

    fn numbers(_: &[T]) -> &[i32] {
        unreachable!()
    }

    fn numbers_mut(_: &mut [T]) -> &mut [i32] {
        unreachable!()
    }
}

impl<T> Fallback<T> for FieldType<T> {}

/// Replaces the rows of a type without a derive.
pub trait FallbackRows<M: Model>: Sized {
    const ROWS: &'static [Part<M>] = &[];
}

impl<T, M: Model, At> FallbackRows<M> for FieldRows<T, M, At> {}

/// Requires that a type is a struct of parameters.
pub const fn is_parameter<T: Parameters>() {}

/// Requires that a type is a struct of inputs.
pub const fn is_input<T: Input>() {}

/// Requires that a type is a struct of outputs.
pub const fn is_output<T: Output>() {}

/// Requires that a type is a part of a state.
pub const fn is_state<T: StatePart>() {}

/// Requires what a skipped field needs, with a start value.
pub const fn is_saved<T: Clone + Serialize + DeserializeOwned>() {}

/// Requires what a skipped field needs, without one.
pub const fn is_saved_default<T: Clone + Default + Serialize + DeserializeOwned>() {}
