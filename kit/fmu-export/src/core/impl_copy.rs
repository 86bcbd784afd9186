//! Copies of what is generic and holds functions, references and numbers only: whatever its
//! parameters are, which a derive would ask to be copied too.

/// Makes types `Copy`; the parameters of each stand before it in brackets.
macro_rules! impl_copy {
    ($([$($parameters:tt)*] $type:ty;)*) => {$(
        impl<$($parameters)*> Clone for $type {
            fn clone(&self) -> Self {
                *self
            }
        }

        impl<$($parameters)*> Copy for $type {}
    )*};
}
pub(crate) use impl_copy;
