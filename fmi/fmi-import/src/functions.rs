//! The C functions of a loaded library, of FMI 2.0 or 3.0, for all kinds of instances, and what the
//! model description says about calling them: sizes of arrays, and whether there is Event Mode.

use std::collections::HashMap;
use std::ffi::c_int;
use std::sync::Arc;

use fmi_description::{Access, Causality, Description, Variable, Version};

use crate::calls::{Exports, Functions2, Functions3};
use crate::names::fmi3_name;
use crate::standard::{Pointer, Text};
use crate::text;
use crate::under_way::Slot;

/// The functions of a loaded library.
pub struct Functions {
    pub(crate) version: VersionFunctions,
    /// Number of elements of each array, by value reference.
    sizes: HashMap<u32, usize>,
    /// Value reference of the independent variable.
    pub(crate) time: Option<u32>,
    has_event_mode: bool,
    /// Names of the variables of FMI 2.0, by a letter for their type and value reference.
    names: HashMap<(char, u32), String>,
}

/// The functions of one version.
#[derive(Clone)]
pub enum VersionFunctions {
    /// FMI 2.0.
    Fmi2(Arc<Functions2>),
    /// FMI 3.0.
    Fmi3(Arc<Functions3>),
}

use VersionFunctions::{Fmi2, Fmi3};

impl Functions {
    /// Looks up the functions of the version of FMI that the description names.
    pub fn load(library: impl Exports, description: &Description) -> Arc<Self> {
        let variables = description.variables.iter();
        let arrays = variables.clone().filter(|v| v.size() > 1);
        let is_time = |v: &&Variable| v.causality == Causality::Independent;
        let time = variables.clone().find(is_time);
        let named = |v: &Variable| ((letter(v.access()), v.reference), v.name.clone());
        let names = match description.fmi {
            // Of aliases, the first.
            Version::Fmi2 => variables.rev().map(named).collect(),
            Version::Fmi3 => HashMap::new(),
        };
        Arc::new(Self {
            names,
            version: match description.fmi {
                Version::Fmi2 => Fmi2(Arc::new(Functions2::load(library))),
                Version::Fmi3 => Fmi3(Arc::new(Functions3::load(library))),
            },
            sizes: arrays.map(|v| (v.reference, v.size())).collect(),
            time: time.map(|v| v.reference),
            has_event_mode: description.capabilities.event_mode,
        })
    }

    /// Whether they are those of FMI 3.0.
    pub fn is_fmi3(&self) -> bool {
        matches!(self.version, Fmi3(_))
    }

    /// The name that a function of FMI 2.0 has in the version of this FMU.
    pub fn name<'a>(&self, name: &'a str) -> &'a str {
        match &self.version {
            Fmi2(_) => name,
            Fmi3(_) => fmi3_name(name),
        }
    }

    /// Whether the library exports the function of this name.
    pub fn exports(&self, name: &str) -> bool {
        match &self.version {
            Fmi2(f) => f.exports(name),
            Fmi3(f) => f.exports(name),
        }
    }

    /// Whether the FMU has Event Mode for co-simulation (FMI 3.0).
    pub fn has_event_mode(&self) -> bool {
        self.has_event_mode && self.is_fmi3()
    }

    /// Whether values may be read after others were set at a communication point: FMI 3.0 allows
    /// that in Event Mode only.
    pub fn reads_after_set(&self) -> bool {
        self.has_event_mode || !self.is_fmi3()
    }

    /// The type that numbers of a type are passed as: in FMI 2.0 a Boolean is a C int.
    #[cfg(feature = "native")]
    pub(crate) fn c_type(&self, access: Access) -> Access {
        match access {
            Access::Boolean if !self.is_fmi3() => Access::Integer,
            access => access,
        }
    }

    /// Name of the variable that a message of FMI 2.0 marks so: `r123` is the Real with the
    /// reference 123.
    pub(crate) fn name_of_mark(&self, mark: &str) -> Option<&str> {
        let kind = mark.chars().next()?;
        let reference = mark.strip_prefix(kind)?.parse().ok()?;
        self.names.get(&(kind, reference)).map(String::as_str)
    }

    /// Number of values of these variables, all elements of arrays included.
    pub fn count(&self, references: &[u32]) -> usize {
        let size = |r: &u32| self.sizes.get(r).copied().unwrap_or(1);
        references.iter().map(size).sum()
    }

    /// The texts that functions without arguments return, fmi2GetVersion for example, with the
    /// names of the functions; None for NULL.
    pub fn versions(&self) -> Vec<(&'static str, Option<String>)> {
        let _call = Slot::fresh().call(c"an FMU");
        // SAFETY: functions without arguments that give NULL or C strings.
        let texts = unsafe {
            match &self.version {
                Fmi2(f) => vec![
                    ("fmi2GetVersion", (f.fmi2GetVersion)()),
                    ("fmi2GetTypesPlatform", (f.fmi2GetTypesPlatform)()),
                ],
                Fmi3(f) => vec![("fmi2GetVersion", (f.fmi3GetVersion)())],
            }
        };
        // SAFETY: as above.
        let read = |text: Text| (!text.is_null()).then(|| unsafe { text::read_or_explain(text) });
        let texts = texts.into_iter();
        texts.map(|(name, text)| (name, read(text))).collect()
    }
}

/// How messages of FMI 2.0 mark references to variables of a type.
fn letter(access: Access) -> char {
    match access {
        Access::Boolean => 'b',
        Access::Integer => 'i',
        Access::String => 's',
        _ => 'r',
    }
}

/// The functions that get and set numbers, one row for each type: their calls with common
/// arguments, and their names.
macro_rules! numbers {
    ($($version:ident $functions:ident { $($access:ident $get:ident $set:ident;)* })*) => {
        $(impl $functions {
            /// Gets numbers of a type into `values`, each in the size of its C type.
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

            /// Sets numbers of a type, each in the size of its C type.
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
            /// Names of the functions that get and set values of a type.
            pub fn names_of(&self, access: Access) -> [&'static str; 2] {
                match (&self.version, access) {
                    $($(($version(_), Access::$access) => [stringify!($get), stringify!($set)],)*)*
                    (Fmi2(_), _) => ["fmi2GetString", "fmi2SetString"],
                    (Fmi3(_), Access::Binary) => ["fmi3GetBinary", "fmi3SetBinary"],
                    (Fmi3(_), Access::Clock) => ["fmi3GetClock", "fmi3SetClock"],
                    (Fmi3(_), _) => ["fmi3GetString", "fmi3SetString"],
                }
            }

            /// Whether this version of FMI has numbers of this type.
            #[cfg(feature = "native")]
            pub(crate) fn has_numbers(&self, access: Access) -> bool {
                match (&self.version, access) {
                    $($(($version(_), Access::$access) => true,)*)*
                    _ => false,
                }
            }
        }
    };
}

/// A call of FMI 2.0, which does not pass the number of values.
macro_rules! Fmi2 {
    ($function:tt($($argument:expr),*), $n:expr) => {{
        let _ = $n;
        $function($($argument),*)
    }};
}

/// A call of FMI 3.0, which passes the number of values last.
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
