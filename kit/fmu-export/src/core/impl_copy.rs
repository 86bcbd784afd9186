//! The macro `impl_copy!` for types of `core`: `Clone` and `Copy` for generic types of functions,
//! references and numbers. A derive would require their type parameters to be `Copy` too.

/// Makes types `Copy`; the type parameters of each stand before it in brackets.
macro_rules! impl_copy {
    ($([$($parameters:tt)*] $type:ty;)*) => {$(
        impl<$($parameters)*> Clone for $type {
            #[inline]
            fn clone(&self) -> Self {
                *self
            }
        }

        impl<$($parameters)*> Copy for $type {}
    )*};
}
pub(crate) use impl_copy;
