//! The macro `setters!`: builder methods in `const` contexts, for rows, units and `Info`.

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
