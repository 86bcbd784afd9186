//! [`Choice`], for models with derives: a field whose type is a Rust enumeration.

use crate::Enumeration;
use crate::core::impl_copy::impl_copy;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::marker::PhantomData;
use std::ops::Deref;
use std::{fmt, slice};

/// A Rust enumeration without data; `#[derive(Enumeration)]` makes it the type of a variable.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be the type of a variable",
    note = "write `#[derive(Clone, Copy, Enumeration)]` on the enumeration"
)]
pub trait Item: Copy + Send + 'static {
    /// Name and items for the model description.
    const ENUMERATION: Enumeration;
    /// The items in order; the first has the number 1.
    const ITEMS: &'static [Self];

    /// Number of the item, from 1.
    fn number(self) -> i32;
}

/// A field that holds an item of the enumeration `E`.
///
/// `*choice` is the item, to compare or to match; `item.into()` makes a choice from an item. It
/// stores the item's number, because importers set numbers; numbers without an item are refused.
#[repr(transparent)]
pub struct Choice<E>(i32, PhantomData<E>);

impl<E> Choice<E> {
    /// No item, in derivatives and seeds of inputs.
    pub(super) const NONE: Self = Self(0, PhantomData);

    /// The numbers of the items.
    #[inline]
    pub(super) fn numbers(choices: &[Self]) -> &[i32] {
        // SAFETY: a choice is a transparent wrapper of a number.
        unsafe { slice::from_raw_parts(choices.as_ptr().cast(), choices.len()) }
    }

    /// The same, to write.
    #[inline]
    pub(super) fn numbers_mut(choices: &mut [Self]) -> &mut [i32] {
        // SAFETY: as above; every number is a choice.
        unsafe { slice::from_raw_parts_mut(choices.as_mut_ptr().cast(), choices.len()) }
    }
}

/// The enumeration of a field of type [`Choice`].
pub trait Enumerated {
    /// Name and items for the model description.
    const ENUMERATION: Enumeration;
}

impl<E: Item> Enumerated for Choice<E> {
    const ENUMERATION: Enumeration = E::ENUMERATION;
}

impl<E: Item> Deref for Choice<E> {
    type Target = E;

    #[inline]
    fn deref(&self) -> &E {
        // Zero, in derivatives and seeds of inputs, is not an item; nor are numbers that a
        // handwritten table may allow.
        let last = E::ITEMS.len() - 1;
        &E::ITEMS[usize::try_from(self.0 - 1).unwrap_or(0).min(last)]
    }
}

impl<E: Item> From<E> for Choice<E> {
    #[inline]
    fn from(item: E) -> Self {
        Self(item.number(), PhantomData)
    }
}

impl_copy! { [E] Choice<E>; }

impl<E> Default for Choice<E> {
    #[inline]
    fn default() -> Self {
        Self::NONE
    }
}

impl<E> PartialEq for Choice<E> {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

impl<E> Eq for Choice<E> {}

impl<E: Item + fmt::Debug> fmt::Debug for Choice<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl<E> Serialize for Choice<E> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de, E> Deserialize<'de> for Choice<E> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self(i32::deserialize(deserializer)?, PhantomData))
    }
}
