//! Values of any type, as texts: numbers as they are written, bytes as hexadecimal digits.

use std::ffi::{CString, c_int};
use std::ptr;

use fmu_description::calls::Functions3;
use fmu_description::{Access, Variable};

use super::instance::Instance;
use super::symbols::{ABSENT, OK, Pointer, Text};

/// Getting and setting numbers of FMI 3.0; None for other types.
macro_rules! numbers {
    ($($access:ident $type:ty: $get:ident $set:ident;)*) => {
        /// The functions of FMI 3.0 that get and set values of a type.
        pub fn names_of(access: Access) -> [&'static str; 2] {
            match access {
                $(Access::$access => [stringify!($get), stringify!($set)],)*
                Access::Boolean => ["fmi3GetBoolean", "fmi3SetBoolean"],
                Access::String => ["fmi3GetString", "fmi3SetString"],
                Access::Binary => ["fmi3GetBinary", "fmi3SetBinary"],
                Access::Clock => ["fmi3GetClock", "fmi3SetClock"],
            }
        }

        unsafe fn get(
            f: &Functions3, access: Access, c: Pointer, vr: &[u32], n: usize,
        ) -> Option<(c_int, Vec<String>)> {
            match access {
                $(Access::$access => {
                    let mut room = vec![<$type>::default(); n];
                    // SAFETY: forwarded; room for all elements.
                    let status = unsafe { (f.$get)(c, vr.as_ptr(), vr.len(), room.as_mut_ptr(), n) };
                    Some((status, room.iter().map(ToString::to_string).collect()))
                })*
                _ => None,
            }
        }

        unsafe fn set(
            f: &Functions3, access: Access, c: Pointer, vr: &[u32], values: &[String],
        ) -> Option<c_int> {
            match access {
                $(Access::$access => {
                    let values = values.iter().map(|text| text.parse::<$type>());
                    let values = values.collect::<Result<Vec<_>, _>>().ok()?;
                    // SAFETY: forwarded; arrays of the lengths given.
                    Some(unsafe { (f.$set)(c, vr.as_ptr(), vr.len(), values.as_ptr(), values.len()) })
                })*
                _ => None,
            }
        }
    };
}

numbers! {
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
        let (vr, n, access) = ([v.reference], v.size(), v.access());
        let f = self.fmu.functions.fmi3();
        // SAFETY: a live instance.
        if let Some(got) = f.and_then(|f| unsafe { get(f, access, self.c, &vr, n) }) {
            return got;
        }
        match (access, f) {
            (Access::String, _) => self.texts(&vr),
            (Access::Real, _) => {
                let (status, values) = self.reals(&vr);
                (status, values.iter().map(ToString::to_string).collect())
            }
            (Access::Binary, Some(f)) => {
                let (mut sizes, mut at) = (vec![0; n], vec![ptr::null(); n]);
                // SAFETY: a live instance, room for all elements.
                let status = unsafe {
                    (f.fmi3GetBinary)(
                        self.c,
                        vr.as_ptr(),
                        1,
                        sizes.as_mut_ptr(),
                        at.as_mut_ptr(),
                        n,
                    )
                };
                let value = |(at, size): (*const u8, usize)| match at.is_null() || size == 0 {
                    true => String::new(),
                    // SAFETY: as many bytes as the FMU says.
                    false => hex(unsafe { std::slice::from_raw_parts(at, size) }),
                };
                match status {
                    OK => (status, at.into_iter().zip(sizes).map(value).collect()),
                    _ => (status, vec![String::new(); n]),
                }
            }
            _ => {
                let (status, values) = self.integers(access, &vr);
                let text = |value: &c_int| match access {
                    Access::Boolean => (*value != 0).to_string(),
                    _ => value.to_string(),
                };
                (status, values.iter().map(text).collect())
            }
        }
    }

    /// Sets a variable, all elements of an array; the status.
    pub fn set_values(&self, v: &Variable, values: &[String]) -> c_int {
        let (vr, access) = ([v.reference], v.access());
        let functions = &self.fmu.functions;
        let f = functions.fmi3();
        // SAFETY: a live instance.
        if let Some(status) = f.and_then(|f| unsafe { set(f, access, self.c, &vr, values) }) {
            return status;
        }
        let numbers = |texts: &[String]| -> Option<Vec<c_int>> {
            let number = |text: &String| match text.as_str() {
                "true" => Some(1),
                "false" => Some(0),
                number => number.parse().ok(),
            };
            texts.iter().map(number).collect()
        };
        match (access, f) {
            (Access::String, _) => {
                let texts: Option<Vec<_>> = values
                    .iter()
                    .map(|v| CString::new(v.as_str()).ok())
                    .collect();
                let texts = texts.unwrap_or_default();
                let at: Vec<Text> = texts.iter().map(|text| text.as_ptr()).collect();
                // SAFETY: a live instance, C strings.
                unsafe { functions.set_string(self.c, vr.as_ptr(), 1, at.as_ptr()) }
            }
            (Access::Real, _) => {
                let reals: Result<Vec<f64>, _> = values.iter().map(|text| text.parse()).collect();
                reals.map_or(ABSENT, |reals| self.set_reals(&vr, &reals))
            }
            (Access::Binary, Some(f)) => {
                let values: Option<Vec<_>> = values.iter().map(|text| bytes(text)).collect();
                let Some(values) = values else { return ABSENT };
                let (at, sizes): (Vec<_>, Vec<_>) =
                    values.iter().map(|v| (v.as_ptr(), v.len())).unzip();
                // SAFETY: a live instance, arrays of the lengths given.
                unsafe {
                    (f.fmi3SetBinary)(
                        self.c,
                        vr.as_ptr(),
                        1,
                        sizes.as_ptr(),
                        at.as_ptr(),
                        at.len(),
                    )
                }
            }
            _ => numbers(values).map_or(ABSENT, |values| {
                let is_boolean = access == Access::Boolean;
                // SAFETY: a live instance, as many values as there are elements.
                unsafe {
                    functions.set_integers(is_boolean, self.c, vr.as_ptr(), 1, values.as_ptr())
                }
            }),
        }
    }
}
