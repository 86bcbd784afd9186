//! Paths to structs nested in parameters, inputs, outputs or states, for generated code.

use super::Name;
use std::marker::PhantomData;

/// The path from a struct of the model to one inside it.
pub trait Path: 'static {
    /// The parameters, inputs or outputs of a model.
    type From;
    /// The struct inside.
    type To;
    /// Its name in the table; empty for the model's struct itself.
    const NAME: Name;

    /// The struct inside.
    fn get(from: &Self::From) -> &Self::To;

    /// The struct inside, mutable.
    fn get_mut(from: &mut Self::From) -> &mut Self::To;
}

/// The path from a struct to itself.
pub struct Root<S>(PhantomData<S>);

impl<S: 'static> Path for Root<S> {
    type From = S;
    type To = S;
    const NAME: Name = Name::EMPTY;

    #[inline]
    fn get(from: &S) -> &S {
        from
    }

    #[inline]
    fn get_mut(from: &mut S) -> &mut S {
        from
    }
}
