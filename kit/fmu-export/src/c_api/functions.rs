//! The macro `functions!`, in which `fmi2` and `fmi3` list their functions: C name, states in which
//! a function may be called, arguments and body.
//!
//! From one list it makes the functions, generic over the model, and a macro that exports them
//! under their C names for one model.

/// `functions! { ($) Fmi2 name_of_the_macro; fmi2Reset [ANY] () |fmi| …; … }`, where `fmi` is the
/// [`FmiInstance`](super::fmi_instance::FmiInstance).
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

/// One function for any model: enters the instance, if the call order allows it, and runs the body.
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
            // SAFETY: the importer must keep the contract of the called function.
            unsafe { e::$name::<$exported>(c $(, $argument)*) }
        }
    )*};
}
