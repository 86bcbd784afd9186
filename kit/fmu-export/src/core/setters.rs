//! The macro `setters!` for rows and `Info`: builder methods that work in `const` contexts.

/// Methods that set one field each: name, arguments, field and its value.
macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty),*) $field:ident = $value:expr;)*) => {$(
        $(#[$doc])*
        pub const fn $name(mut self $(, $argument: $type)*) -> Self {
            self.$field = $value;
            self
        }
    )*};
}
pub(crate) use setters;
