//! The functions of FMI 2.0 and 3.0 as a library exports them. A function that is missing is missed
//! when it is called, not when the library is loaded: many libraries lack some that they never need.
#![allow(unsafe_code, non_snake_case, missing_docs)]

use std::ffi::{c_int, c_void};

pub use fmu_description::functions::{Pointer as Handle, Text};
use fmu_description::{fmi2_functions, fmi3_functions, functions::Pointer};

use super::library::Library;

/// What FMI 2.0 calls `fmi2CallbackFunctions`.
#[repr(C)]
pub struct Callbacks {
    /// Variadic.
    pub logger: unsafe extern "C" fn(Handle, Text, c_int, Text, Text, ...),
    pub allocate_memory: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    pub free_memory: unsafe extern "C" fn(*mut c_void),
    pub step_finished: *const c_void,
    pub environment: Handle,
}

/// The logger of FMI 3.0: environment, status, category, message.
pub type Logger = unsafe extern "C" fn(Handle, c_int, Text, Text);

macro_rules! functions {
    ($api:ident $($function:ident $interface:ident [$($states:tt)*] ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// By their C names.
        #[allow(dead_code, reason = "the list has functions that the master does not call")]
        pub struct $api {
            $(pub $function: Option<unsafe extern "C" fn($($argument),*) $(-> $result)?>,)*
            _library: Library,
        }

        impl $api {
            /// The functions that `library` exports.
            pub fn of(library: Library) -> Self {
                Self {
                    // SAFETY: the type is that of the function in the standard's headers.
                    $($function: unsafe { library.function(stringify!($function)) },)*
                    _library: library,
                }
            }
        }
    };
}

fmi2_functions!(functions! Functions2);
fmi3_functions!(functions! Functions3);

/// Calls a function of a library; an error where it is missing or does not do it.
macro_rules! call {
    ($api:expr, $function:ident($($argument:expr),* $(,)?)) => {
        match $api.$function {
            Some(function) => Answer::check(function($($argument),*), stringify!($function)),
            None => Answer::refuse(Answer::MISSING, stringify!($function)),
        }
    };
}
pub(crate) use call;
