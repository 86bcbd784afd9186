//! Values of any type, as texts: numbers as they are written, truth values as `true` and `false`,
//! bytes as hexadecimal digits.

use std::ffi::{CString, c_int};

use fmi_description::{Access, Variable};

use crate::encoding::{load, store};
use crate::instance::Instance;
use crate::raw::Array;
use crate::status::{ABSENT, NO_TEXT};
use crate::value::bytes;

impl Instance<'_> {
    /// The values of a variable, of an array one for each element.
    pub fn values(&self, v: &Variable) -> (c_int, Vec<String>) {
        self.values_of(v.access(), &[v.reference], false)
    }

    /// Sets a variable, all elements of an array; the status.
    pub fn set_values(&self, v: &Variable, values: &[String]) -> c_int {
        self.set_values_of(v.access(), &[v.reference], values, [false; 2])
    }

    /// Values of variables of a type, of arrays one for each element; the place for numbers may be
    /// NULL.
    pub fn values_of(&self, access: Access, vr: &[u32], is_null: bool) -> (c_int, Vec<String>) {
        let n = self.fmu.functions.count(vr);
        match access {
            _ if self.fmu.functions.has_numbers(access) => {
                let mut room = vec![0; n];
                let place = (!is_null).then_some(&mut room[..]);
                let status = self.get_numbers(access, Array::Elements(vr), place, n);
                let stored = self.stored(access);
                let shown = |k| shown(access, load(stored, &room, k));
                (status, (0..n).map(shown).collect())
            }
            Access::Binary => {
                let (status, values) = self.get_binaries(vr, n);
                let hex =
                    |bytes: &Vec<u8>| bytes.iter().map(|byte| format!("{byte:02x}")).collect();
                (status, values.iter().map(hex).collect())
            }
            Access::Clock => (ABSENT, Vec::new()),
            _ => self.texts(vr),
        }
    }

    /// Sets variables of a type, all elements of arrays; references and numbers may be NULL. The
    /// status.
    pub fn set_values_of(
        &self,
        access: Access,
        vr: &[u32],
        values: &[String],
        [no_vr, no_values]: [bool; 2],
    ) -> c_int {
        let n = values.len();
        assert_eq!(self.fmu.functions.count(vr), n);
        match access {
            _ if self.fmu.functions.has_numbers(access) => {
                let (mut numbers, stored) = (vec![0; n], self.stored(access));
                for (k, text) in values.iter().enumerate() {
                    let Some(bits) = number(access, text) else {
                        return ABSENT;
                    };
                    store(stored, &mut numbers, k, bits);
                }
                let given = Array::or_null(&numbers, no_values);
                self.set_numbers(access, Array::or_null(vr, no_vr), given, n)
            }
            Access::Binary => {
                let values: Option<Vec<_>> = values.iter().map(|text| bytes(text)).collect();
                let Some(values) = values else { return ABSENT };
                let values: Vec<_> = values.iter().map(Vec::as_slice).collect();
                self.set_binaries(vr, &values)
            }
            Access::Clock => ABSENT,
            _ => {
                let texts = values.iter().map(|text| CString::new(text.as_str()).ok());
                let Some(texts) = texts.collect::<Option<Vec<_>>>() else {
                    return ABSENT;
                };
                let texts: Vec<_> = texts.iter().map(|text| Some(text.as_c_str())).collect();
                self.set_strings(vr, &texts)
            }
        }
    }

    /// Values of String variables; the status is [`NO_TEXT`] where a pointer leads nowhere.
    pub fn texts(&self, vr: &[u32]) -> (c_int, Vec<String>) {
        let (status, texts) = self.get_strings(vr, self.fmu.functions.count(vr));
        let Some(texts) = texts else {
            return (NO_TEXT, Vec::new());
        };
        let texts = texts.iter().map(|text| text.to_string_lossy().into_owned());
        (status, texts.collect())
    }

    /// The type that numbers of this one have in C: truth values of FMI 2.0 are integers.
    fn stored(&self, access: Access) -> Access {
        match access {
            Access::Boolean if !self.fmu.functions.is_3() => Access::Integer,
            access => access,
        }
    }
}

fn shown(access: Access, bits: u64) -> String {
    match access {
        Access::Real => f64::from_bits(bits).to_string(),
        Access::Float32 => (f64::from_bits(bits) as f32).to_string(),
        Access::Boolean => (bits != 0).to_string(),
        Access::UInt64 => bits.to_string(),
        _ => bits.cast_signed().to_string(),
    }
}

/// Any number but 0 is a truth value.
fn number(access: Access, text: &str) -> Option<u64> {
    match (access, text) {
        (Access::Real | Access::Float32, _) => text.parse().ok().map(f64::to_bits),
        (Access::Boolean, "true") => Some(1),
        (Access::Boolean, "false") => Some(0),
        (Access::UInt64, _) => text.parse().ok(),
        _ => text.parse().ok().map(i64::cast_unsigned),
    }
}
