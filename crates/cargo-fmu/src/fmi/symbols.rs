//! Looking up the C functions of a library by name. A function that is missing is missed when it is
//! called, not when the library is loaded: what is called in its place answers [`ABSENT`].

use std::ffi::c_int;
use std::ptr;

pub use fmu_description::functions::{Pointer, Text};

/// Status: all is well.
pub const OK: c_int = 0;
/// Status: done, but something is to be told.
pub const WARNING: c_int = 1;
/// Status: not done, and nothing has changed.
pub const DISCARD: c_int = 2;
/// Status: a wrong call.
pub const ERROR: c_int = 3;
/// No status: the library does not export the function.
pub const ABSENT: c_int = 1000;

/// What is answered in the place of a function that is missing.
pub trait Absent {
    /// The answer.
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
    ($($name:ident $interface:ident [$($states:tt)*] ($($type:ty),*) $(-> $result:ty)?;)*) => {
        /// One pointer for each function.
        #[allow(non_snake_case, missing_docs)] // named as in the standard
        pub struct Functions {
            $(pub $name: unsafe extern "C" fn($($type),*) $(-> $result)?,)*
            _library: libloading::Library,
        }

        #[allow(non_snake_case)]
        impl Functions {
            /// Find them in a library.
            pub fn load(library: libloading::Library) -> Self {
                $(
                    unsafe extern "C" fn $name($(_: $type),*) $(-> $result)? {
                        $crate::fmi::symbols::Absent::absent()
                    }
                    let name = concat!(stringify!($name), "\0").as_bytes();
                    // SAFETY: an FMU exports this name with this signature.
                    let found = unsafe { library.get::<unsafe extern "C" fn($($type),*) $(-> $result)?>(name) };
                    let $name = found.map_or(
                        $name as unsafe extern "C" fn($($type),*) $(-> $result)?,
                        |symbol| *symbol,
                    );
                )*
                Self { $($name,)* _library: library }
            }
        }
    };
}

pub(super) use functions;
