//! Values of any type, as texts: numbers as they are written, truth values as `true` and `false`,
//! bytes as hexadecimal digits.

use std::ffi::{CString, c_int};
use std::fmt::Display;
use std::str::FromStr;
use std::{ptr, slice};

use fmi_description::{Access, Variable};

use super::functions::Functions;
use super::functions::OwnFunctions::{Fmi2, Fmi3};
use super::instance::Instance;
use super::symbols::{ABSENT, OK, WARNING};

/// The functions of each type of numbers, and their type in C.
macro_rules! numbers {
    ($($version:ident { $($access:ident $type:ty: $get:ident $set:ident;)* })*) => {
        impl Functions {
            /// The functions that get and set values of a type.
            pub fn names_of(&self, access: Access) -> [&'static str; 2] {
                match (self.own(), access) {
                    $($(($version(_), Access::$access) => [stringify!($get), stringify!($set)],)*)*
                    (Fmi2(_), _) => ["fmi2GetString", "fmi2SetString"],
                    (Fmi3(_), Access::Binary) => ["fmi3GetBinary", "fmi3SetBinary"],
                    (Fmi3(_), Access::Clock) => ["fmi3GetClock", "fmi3SetClock"],
                    (Fmi3(_), _) => ["fmi3GetString", "fmi3SetString"],
                }
            }
        }

        impl Instance<'_> {
            /// Values of variables of a type, of arrays one for each element; the place for numbers
            /// may be NULL.
            pub fn values_of(&self, access: Access, vr: &[u32], is_null: bool) -> (c_int, Vec<String>) {
                let n = self.fmu.functions.count(vr);
                match (self.fmu.functions.own(), access) {
                    $($(($version(f), Access::$access) => {
                        let mut room = vec![<$type>::default(); n];
                        let place = if is_null { ptr::null_mut() } else { room.as_mut_ptr() };
                        // SAFETY: a live instance; NULL or room for all elements.
                        let status = unsafe { $version!((f.$get)(self.c, vr.as_ptr(), vr.len(), place.cast()), n) };
                        (status, room.iter().map(|value| shown(access, value)).collect())
                    })*)*
                    (_, Access::Binary) => self.binaries(vr, n),
                    (_, Access::Clock) => (ABSENT, Vec::new()),
                    _ => self.texts(vr),
                }
            }

            /// Sets variables of a type, all elements of arrays; references and numbers may be NULL.
            /// The status.
            pub fn set_values_of(
                &self, access: Access, vr: &[u32], values: &[String], [no_vr, no_values]: [bool; 2],
            ) -> c_int {
                assert_eq!(self.fmu.functions.count(vr), values.len());
                let at = if no_vr { ptr::null() } else { vr.as_ptr() };
                match (self.fmu.functions.own(), access) {
                    $($(($version(f), Access::$access) => {
                        let numbers = values.iter().map(|text| number::<$type>(access, text));
                        let Some(numbers) = numbers.collect::<Option<Vec<_>>>() else { return ABSENT };
                        let place = if no_values { ptr::null() } else { numbers.as_ptr() };
                        // SAFETY: a live instance; NULL or arrays of the lengths given.
                        unsafe { $version!((f.$set)(self.c, at, vr.len(), place.cast()), numbers.len()) }
                    })*)*
                    (_, Access::Binary) => self.set_binaries(vr, values),
                    (_, Access::Clock) => ABSENT,
                    _ => self.set_texts(vr, values),
                }
            }
        }
    };
}

/// A call of FMI 2.0, which is not told the number of values.
macro_rules! Fmi2 {
    ($function:tt($($argument:expr),*), $n:expr) => { $function($($argument),*) };
}

/// A call of FMI 3.0, which is told it.
macro_rules! Fmi3 {
    ($function:tt($($argument:expr),*), $n:expr) => { $function($($argument,)* $n) };
}

numbers! {
    Fmi2 {
        Real f64: fmi2GetReal fmi2SetReal;
        Integer c_int: fmi2GetInteger fmi2SetInteger;
        Boolean c_int: fmi2GetBoolean fmi2SetBoolean;
    }
    Fmi3 {
        Real f64: fmi3GetFloat64 fmi3SetFloat64;
        Float32 f32: fmi3GetFloat32 fmi3SetFloat32;
        Int8 i8: fmi3GetInt8 fmi3SetInt8;
        UInt8 u8: fmi3GetUInt8 fmi3SetUInt8;
        Int16 i16: fmi3GetInt16 fmi3SetInt16;
        UInt16 u16: fmi3GetUInt16 fmi3SetUInt16;
        Integer i32: fmi3GetInt32 fmi3SetInt32;
        UInt32 u32: fmi3GetUInt32 fmi3SetUInt32;
        Int64 i64: fmi3GetInt64 fmi3SetInt64;
        UInt64 u64: fmi3GetUInt64 fmi3SetUInt64;
        Boolean u8: fmi3GetBoolean fmi3SetBoolean; // an FMU may write what is no bool
    }
}

fn shown(access: Access, value: &impl Display) -> String {
    let text = value.to_string();
    match access {
        Access::Boolean => (text != "0").to_string(),
        _ => text,
    }
}

fn number<T: FromStr>(access: Access, text: &str) -> Option<T> {
    let text = match (access, text) {
        (Access::Boolean, "true") => "1",
        (Access::Boolean, "false") => "0",
        _ => text,
    };
    text.parse().ok()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(text: &str) -> Option<Vec<u8>> {
    let pairs = text.as_bytes().chunks(2);
    let pairs = pairs.map(|pair| u8::from_str_radix(str::from_utf8(pair).ok()?, 16).ok());
    pairs.collect()
}

impl Instance<'_> {
    /// The values of a variable, of an array one for each element.
    pub fn values(&self, v: &Variable) -> (c_int, Vec<String>) {
        self.values_of(v.access(), &[v.reference], false)
    }

    /// Sets a variable, all elements of an array; the status.
    pub fn set_values(&self, v: &Variable, values: &[String]) -> c_int {
        self.set_values_of(v.access(), &[v.reference], values, [false; 2])
    }

    fn set_texts(&self, vr: &[u32], values: &[String]) -> c_int {
        let texts = values.iter().map(|text| CString::new(text.as_str()).ok());
        let Some(texts) = texts.collect::<Option<Vec<_>>>() else {
            return ABSENT;
        };
        let at: Vec<_> = texts.iter().map(|text| text.as_ptr()).collect();
        let f = &self.fmu.functions;
        // SAFETY: a live instance, C strings.
        unsafe { f.set_string(self.c, vr.as_ptr(), vr.len(), at.as_ptr()) }
    }

    fn binaries(&self, vr: &[u32], n: usize) -> (c_int, Vec<String>) {
        let Some(f) = self.fmu.functions.fmi3() else {
            return (ABSENT, Vec::new());
        };
        let (mut sizes, mut at) = (vec![0; n], vec![ptr::null(); n]);
        let (sizes_at, values_at) = (sizes.as_mut_ptr(), at.as_mut_ptr());
        // SAFETY: a live instance, room for all elements.
        let status =
            unsafe { (f.fmi3GetBinary)(self.c, vr.as_ptr(), vr.len(), sizes_at, values_at, n) };
        let value = |(at, size): (*const u8, usize)| match at.is_null() || size == 0 {
            true => String::new(),
            // SAFETY: as many bytes as the FMU says.
            false => hex(unsafe { slice::from_raw_parts(at, size) }),
        };
        match status {
            OK | WARNING => (status, at.into_iter().zip(sizes).map(value).collect()),
            _ => (status, vec![String::new(); n]),
        }
    }

    fn set_binaries(&self, vr: &[u32], values: &[String]) -> c_int {
        let values: Option<Vec<_>> = values.iter().map(|text| bytes(text)).collect();
        let (Some(f), Some(values)) = (self.fmu.functions.fmi3(), values) else {
            return ABSENT;
        };
        let (at, sizes): (Vec<_>, Vec<_>) = values.iter().map(|v| (v.as_ptr(), v.len())).unzip();
        let (n, sizes, at) = (at.len(), sizes.as_ptr(), at.as_ptr());
        // SAFETY: a live instance, arrays of the lengths given.
        unsafe { (f.fmi3SetBinary)(self.c, vr.as_ptr(), vr.len(), sizes, at, n) }
    }
}
