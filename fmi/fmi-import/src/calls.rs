//! The C functions of an FMU as pointers, looked up by name in what was loaded, for `functions`.
//! Many libraries lack functions that are never called, so a missing one is no error at loading:
//! what is called instead of it returns [`ABSENT`].
#![allow(unsafe_code, non_snake_case)] // named as in the standard

use std::any::Any;
use std::ffi::{c_int, c_void};
use std::ptr;

pub use crate::standard::Logger;
use crate::standard::{Pointer, Text, fmi2_functions, fmi3_functions};
use crate::status::ABSENT;
use crate::under_way::Noted;

/// A loaded library or module, which exports functions for as long as it lives.
pub trait Exports: Any + Send + Sync {
    /// The exported function `name`.
    ///
    /// # Safety
    /// `F` is the type of a pointer to that function.
    unsafe fn function<F: Copy>(&self, name: &str) -> Option<F>;
}

/// Functions that this program has itself, by name.
#[derive(Clone, Copy)]
pub struct Offered(pub fn(&str) -> Option<*const c_void>);

impl Exports for Offered {
    unsafe fn function<F: Copy>(&self, name: &str) -> Option<F> {
        // SAFETY: a pointer to the function of this name, as the caller promises.
        (self.0)(name).map(|function| unsafe { std::mem::transmute_copy(&function) })
    }
}

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub struct Callbacks {
    /// `fmi2CallbackLogger`, which is variadic.
    pub logger: *const c_void,
    /// As `calloc`; NULL where an FMU declares canNotUseMemoryManagementFunctions.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> Pointer>,
    /// As `free`.
    pub free_memory: Option<unsafe extern "C" fn(Pointer)>,
    /// NULL, since steps are synchronous.
    pub step_finished: *const c_void,
    /// What the FMU passes to the logger.
    pub environment: Pointer,
}

/// What is returned where a function is missing.
trait Absent {
    fn absent() -> Self;
}

impl Absent for () {
    fn absent() {}
}

impl Absent for c_int {
    fn absent() -> Self {
        ABSENT
    }
}

impl Absent for Pointer {
    fn absent() -> Self {
        ptr::null_mut()
    }
}

impl Absent for Text {
    fn absent() -> Self {
        ptr::null()
    }
}

macro_rules! functions {
    ($api:ident $($name:ident $interface:ident [$($states:tt)*] ($($type:ty),*) $(-> $result:ty)?;)*) => {
        /// One pointer for each function of this version.
        #[allow(dead_code)] // all are looked up, so that `exports` knows which are there
        pub struct $api {
            $(pub(crate) $name: Noted<unsafe extern "C" fn($($type),*) $(-> $result)?>,)*
            absent: Vec<&'static str>,
            _library: Box<dyn Any + Send + Sync>,
        }

        impl $api {
            /// Looks up the functions that `library` exports.
            pub fn load(library: impl Exports) -> Self {
                let mut absent = Vec::new();
                $(
                    unsafe extern "C" fn $name($(_: $type),*) $(-> $result)? {
                        Absent::absent()
                    }
                    // SAFETY: the type is that of the function in the standard's headers.
                    let found = unsafe { library.function(stringify!($name)) };
                    let $name = found.unwrap_or_else(|| {
                        absent.push(stringify!($name));
                        $name as unsafe extern "C" fn($($type),*) $(-> $result)?
                    });
                    let $name = Noted::new($name, stringify!($name));
                )*
                Self { $($name,)* absent, _library: Box::new(library) }
            }

            /// Whether the library exports the function of this name.
            pub fn exports(&self, name: &str) -> bool {
                !self.absent.contains(&name)
            }
        }
    };
}

fmi2_functions!(functions! Functions2);
fmi3_functions!(functions! Functions3);
