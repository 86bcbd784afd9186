//! What the derives write of a field whose type is a struct, so that a missing derive is said once.
//!
//! That the struct is one of parameters, of inputs or of outputs is asked for in one place, where
//! the compiler says it in the words of that trait. Everything else that is written of the field
//! goes through [`FieldType`]: its functions are those of the type where it has what they need, and
//! else those of [`Fallback`], which are never called, because what has such a field does not
//! compile.

use super::{Choice, Item, Output, Part, Rows, Vector};
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

/// In place of what a type has not.
pub trait Fallback<T>: Sized {
    fn copied(_: &T) -> T {
        unreachable!()
    }

    fn copied_to(_: &T, _: &mut T) {}

    fn zero() -> T {
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

/// In place of the rows that a type has not.
pub trait FallbackRows<M: Model>: Sized {
    const ROWS: &'static [Part<M>] = &[];
}

impl<T, M: Model, At> FallbackRows<M> for FieldRows<T, M, At> {}

/// Asks that a type is a struct of outputs, or a part of a state.
pub const fn is_output<T: Output>() {}
