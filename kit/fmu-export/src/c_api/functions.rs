//! How a version of FMI lists its functions: name in C, states in which it may be called (its call
//! order), arguments, what it does.
//!
//! From one list come the functions for any model and the macro that gives them their C names for
//! one model.

/// `functions! { ($) Version name_of_the_macro; fmi2Reset [I | N | S] () |b| …; … }`; `b` is the
/// instance's `Body`.
macro_rules! functions {
    (($d:tt) $version:ident $export:ident; $(
        $(#[$doc:meta])*
        $name:ident [$($allowed:tt)*] $arguments:tt $run:expr;
    )*) => {
        $($crate::c_api::functions::function! {
            $(#[$doc])* $version $name [$($allowed)*] $arguments $run
        })*

        #[doc(hidden)]
        #[macro_export]
        macro_rules! $export {
            ($d exported:ty) => {
                $crate::export_functions! { $d exported; $($name $arguments;)* }
            };
        }
    };
}
pub(crate) use functions;

/// One function for any model: it enters the instance, if the call order allows it, and does what
/// it does there.
macro_rules! function {
    ($(#[$doc:meta])* $version:ident $name:ident [$allowed:expr] ($($argument:ident: $type:ty),* $(,)?) $run:expr) => {
        #[doc = concat!("`", stringify!($name), "`.")]
        $(#[$doc])*
        ///
        /// # Safety
        /// See the module `entry`.
        #[allow(non_snake_case, clippy::too_many_arguments)]
        pub unsafe fn $name<X: $crate::c_api::export::Exported>(
            c: *mut std::ffi::c_void,
            $($argument: $type),*
        ) -> Status {
            const CALL: $crate::c_api::call_order::Call =
                $crate::c_api::call_order::Call::new(stringify!($name), $allowed);
            $(let _ = &$argument;)*
            // SAFETY: forwarded.
            unsafe { $crate::c_api::fmi_instance::enter::<X::Model, $version>(c, CALL, $run) }
        }
    };
}
pub(crate) use function;

/// Part of [`export_fmu!`](crate::export_fmu).
#[doc(hidden)]
#[macro_export]
macro_rules! export_functions {
    ($exported:ty; $($name:ident($($argument:ident: $type:ty),* $(,)?);)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C-unwind" fn $name(c: *mut c_void $(, $argument: $type)*) -> Status {
            // SAFETY: FMI asks of the importer what the called function asks for.
            unsafe { e::$name::<$exported>(c $(, $argument)*) }
        }
    )*};
}
