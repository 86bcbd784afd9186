//! The functions of a loaded library, of either version, with what the model description says
//! about how they are called.

use std::collections::HashMap;
use std::ffi::c_int;
use std::sync::Arc;

use fmi_description::{Access, Causality, Description, Version};

use crate::calls::{Exports, Functions2, Functions3};
use crate::names::in_3;
use crate::standard::{Pointer, Text};
use crate::text;

/// The functions of a loaded library.
pub struct Functions {
    pub(crate) own: OwnFunctions,
    /// Number of values by value reference; scalars are left out.
    sizes: HashMap<u32, usize>,
    /// Value reference of the time.
    pub(crate) time: Option<u32>,
    has_event_mode: bool,
}

/// Those of one version.
#[derive(Clone)]
pub enum OwnFunctions {
    /// FMI 2.0.
    Fmi2(Arc<Functions2>),
    /// FMI 3.0.
    Fmi3(Arc<Functions3>),
}

use OwnFunctions::{Fmi2, Fmi3};

impl Functions {
    /// Those of the version that the description names.
    pub fn load(library: impl Exports, description: &Description) -> Arc<Self> {
        let variables = description.variables.iter();
        let arrays = variables.clone().filter(|v| v.size() > 1);
        let time = variables
            .clone()
            .find(|v| v.causality == Causality::Independent);
        Arc::new(Self {
            own: match description.fmi {
                Version::Fmi2 => Fmi2(Arc::new(Functions2::of(library))),
                Version::Fmi3 => Fmi3(Arc::new(Functions3::of(library))),
            },
            sizes: arrays.map(|v| (v.reference, v.size())).collect(),
            time: time.map(|v| v.reference),
            has_event_mode: description.capabilities.event_mode,
        })
    }

    /// They are those of FMI 3.0.
    pub fn is_3(&self) -> bool {
        matches!(self.own, Fmi3(_))
    }

    /// The name, in the version of the FMU, of a function named as in FMI 2.0.
    pub fn name<'a>(&self, name: &'a str) -> &'a str {
        match &self.own {
            Fmi2(_) => name,
            Fmi3(_) => in_3(name),
        }
    }

    /// Whether the library exports the function of this name.
    pub fn exports(&self, name: &str) -> bool {
        match &self.own {
            Fmi2(f) => f.exports(name),
            Fmi3(f) => f.exports(name),
        }
    }

    /// Instances go through Event Mode.
    pub fn has_event_mode(&self) -> bool {
        self.has_event_mode && self.is_3()
    }

    /// At a communication point values are read after others were set: in FMI 3.0 in Event Mode
    /// only.
    pub fn reads_after_set(&self) -> bool {
        self.has_event_mode || !self.is_3()
    }

    /// Number of values of these variables.
    pub fn count(&self, references: &[u32]) -> usize {
        let size = |r: &u32| self.sizes.get(r).copied().unwrap_or(1);
        references.iter().map(size).sum()
    }

    /// What the library says about itself by functions without arguments: their names and texts,
    /// None for NULL.
    pub fn versions(&self) -> Vec<(&'static str, Option<String>)> {
        // SAFETY: functions without arguments that give NULL or C strings.
        let texts = unsafe {
            match &self.own {
                Fmi2(f) => vec![
                    ("fmi2GetVersion", (f.fmi2GetVersion)()),
                    ("fmi2GetTypesPlatform", (f.fmi2GetTypesPlatform)()),
                ],
                Fmi3(f) => vec![("fmi2GetVersion", (f.fmi3GetVersion)())],
            }
        };
        // SAFETY: as above.
        let read = |text: Text| (!text.is_null()).then(|| unsafe { text::shown(text) });
        let texts = texts.into_iter();
        texts.map(|(name, text)| (name, read(text))).collect()
    }
}

/// The functions that get and set numbers of each type, one row a type: where they are called with
/// the same arguments, and what they are called.
macro_rules! numbers {
    ($($version:ident $functions:ident { $($access:ident $get:ident $set:ident;)* })*) => {
        $(impl $functions {
            /// Gets numbers of a type into `values`, which each have the size of their C type.
            ///
            /// # Safety
            /// A live instance or NULL, NULL or `m` references, NULL or room for `n` values.
            #[inline]
            pub(crate) unsafe fn get_numbers(
                &self, access: Access, c: Pointer, vr: *const u32, m: usize, values: *mut u64, n: usize,
            ) -> c_int {
                match access {
                    // SAFETY: forwarded.
                    $(Access::$access => unsafe { $version!((self.$get)(c, vr, m, values.cast()), n) },)*
                    other => unreachable!("{other:?} is no number"),
                }
            }

            /// Sets numbers of a type likewise.
            ///
            /// # Safety
            /// A live instance or NULL, NULL or `m` references, NULL or `n` values.
            #[inline]
            pub(crate) unsafe fn set_numbers(
                &self, access: Access, c: Pointer, vr: *const u32, m: usize, values: *const u64, n: usize,
            ) -> c_int {
                match access {
                    // SAFETY: forwarded.
                    $(Access::$access => unsafe { $version!((self.$set)(c, vr, m, values.cast()), n) },)*
                    other => unreachable!("{other:?} is no number"),
                }
            }
        })*

        impl Functions {
            /// The functions that get and set values of a type.
            pub fn names_of(&self, access: Access) -> [&'static str; 2] {
                match (&self.own, access) {
                    $($(($version(_), Access::$access) => [stringify!($get), stringify!($set)],)*)*
                    (Fmi2(_), _) => ["fmi2GetString", "fmi2SetString"],
                    (Fmi3(_), Access::Binary) => ["fmi3GetBinary", "fmi3SetBinary"],
                    (Fmi3(_), Access::Clock) => ["fmi3GetClock", "fmi3SetClock"],
                    (Fmi3(_), _) => ["fmi3GetString", "fmi3SetString"],
                }
            }

            /// Whether the version has functions for numbers of this type.
            #[cfg(feature = "native")]
            pub(crate) fn has_numbers(&self, access: Access) -> bool {
                match (&self.own, access) {
                    $($(($version(_), Access::$access) => true,)*)*
                    _ => false,
                }
            }
        }
    };
}

/// A call of FMI 2.0, which is not told the number of values.
macro_rules! Fmi2 {
    ($function:tt($($argument:expr),*), $n:expr) => {{
        let _ = $n;
        $function($($argument),*)
    }};
}

/// A call of FMI 3.0, which is told it.
macro_rules! Fmi3 {
    ($function:tt($($argument:expr),*), $n:expr) => { $function($($argument,)* $n) };
}

numbers! {
    Fmi2 Functions2 {
        Real fmi2GetReal fmi2SetReal;
        Integer fmi2GetInteger fmi2SetInteger;
        Boolean fmi2GetBoolean fmi2SetBoolean;
    }
    Fmi3 Functions3 {
        Real fmi3GetFloat64 fmi3SetFloat64;
        Float32 fmi3GetFloat32 fmi3SetFloat32;
        Int8 fmi3GetInt8 fmi3SetInt8;
        UInt8 fmi3GetUInt8 fmi3SetUInt8;
        Int16 fmi3GetInt16 fmi3SetInt16;
        UInt16 fmi3GetUInt16 fmi3SetUInt16;
        Integer fmi3GetInt32 fmi3SetInt32;
        UInt32 fmi3GetUInt32 fmi3SetUInt32;
        Int64 fmi3GetInt64 fmi3SetInt64;
        UInt64 fmi3GetUInt64 fmi3SetUInt64;
        Boolean fmi3GetBoolean fmi3SetBoolean;
    }
}
