//! Where a struct lives within the structs of a model.

use super::Name;
use std::marker::PhantomData;

/// The way from a struct of the model to one inside it.
pub trait Path: 'static {
    /// Where it begins: the parameters, inputs or outputs of a model.
    type From;
    /// What it leads to.
    type To;
    /// Name of that in the table, empty for the model's struct itself.
    const NAME: Name;

    /// What it leads to.
    fn get(from: &Self::From) -> &Self::To;

    /// What it leads to, to write.
    fn get_mut(from: &mut Self::From) -> &mut Self::To;
}

/// The way from a struct to itself.
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
