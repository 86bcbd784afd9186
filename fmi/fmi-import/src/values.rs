//! Values of variables of any type and derivatives, read and set by an [`Instance`] for `fmu-check`
//! and `torture`. Values are texts: decimal numbers, `true`, `false`, bytes as hexadecimal digits.

use std::ffi::{CString, c_int};

use fmi_description::{Access, Variable};

use crate::encoding::{load, store};
use crate::instance::Instance;
use crate::raw::Array;
use crate::status::{ABSENT, NO_TEXT};
use crate::value::bytes;

impl Instance<'_> {
    /// The status, and the values of a variable: of an array one for each element.
    pub fn values(&self, v: &Variable) -> (c_int, Vec<String>) {
        self.values_of(v.access(), &[v.reference], false)
    }

    /// Sets a variable, all elements of an array; returns the status.
    pub fn set_values(&self, v: &Variable, values: &[String]) -> c_int {
        self.set_values_of(v.access(), &[v.reference], values, [false; 2])
    }

    /// The status, and the values of variables of one type. With `is_null`, NULL is passed for the
    /// numbers to be written to.
    pub fn values_of(&self, access: Access, vr: &[u32], is_null: bool) -> (c_int, Vec<String>) {
        if let Some(all) = self.one_by_one(vr, |one| self.values_of(access, one, is_null)) {
            return all;
        }
        let n = self.fmu.functions.count(vr);
        match access {
            _ if self.fmu.functions.has_numbers(access) => {
                let mut numbers = vec![0; n];
                let place = (!is_null).then_some(&mut numbers[..]);
                let status = self.get_numbers(access, Array::Elements(vr), place, n);
                let c_type = self.fmu.functions.c_type(access);
                let text = |k| number_to_text(access, load(c_type, &numbers, k));
                (status, (0..n).map(text).collect())
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

    /// Sets variables of one type, all elements of arrays; returns the status. NULL is passed for
    /// the references or the numbers on request.
    pub fn set_values_of(
        &self,
        access: Access,
        vr: &[u32],
        values: &[String],
        [no_vr, no_values]: [bool; 2],
    ) -> c_int {
        let n = values.len();
        assert_eq!(self.fmu.functions.count(vr), n);
        self.one_by_one(&vr[..vr.len().min(1)], |_| (0, vec![()]));
        match access {
            _ if self.fmu.functions.has_numbers(access) => {
                let (mut numbers, c_type) = (vec![0; n], self.fmu.functions.c_type(access));
                for (k, text) in values.iter().enumerate() {
                    let Some(bits) = text_to_number(access, text) else {
                        return ABSENT;
                    };
                    store(c_type, &mut numbers, k, bits);
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

    /// The status, and the values of String variables; [`NO_TEXT`] if a pointer leads to no text.
    pub fn texts(&self, vr: &[u32]) -> (c_int, Vec<String>) {
        if let Some(all) = self.one_by_one(vr, |one| self.texts(one)) {
            return all;
        }
        let (status, texts) = self.get_strings(vr, self.fmu.functions.count(vr));
        let Some(texts) = texts else {
            return (NO_TEXT, Vec::new());
        };
        let texts = texts.iter().map(|text| text.to_string_lossy().into_owned());
        (status, texts.collect())
    }

    /// The status, and the directional derivatives of the unknowns along the seed of the knowns.
    pub fn directional(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> (c_int, Vec<f64>) {
        let f = &self.fmu.functions;
        assert_eq!(f.count(knowns), seed.len());
        let mut result = vec![0.0; f.count(unknowns)];
        let status = self.get_directional_derivative(unknowns, knowns, seed, &mut result);
        (status, result)
    }

    /// The status, and the adjoint derivatives of FMI 3.0. A seed that is too short is passed as it
    /// is.
    pub fn adjoint(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> (c_int, Vec<f64>) {
        let mut result = vec![0.0; self.fmu.functions.count(knowns)];
        let status = self.get_adjoint_derivative(unknowns, knowns, seed, &mut result);
        (status, result)
    }

    /// The status, and the time derivatives of outputs, of these orders.
    pub fn output_derivatives(&self, references: &[u32], orders: &[c_int]) -> (c_int, Vec<f64>) {
        let mut values = vec![0.0; self.fmu.functions.count(references)];
        let status = self.get_output_derivatives(references, orders, &mut values);
        (status, values)
    }
}

fn number_to_text(access: Access, bits: u64) -> String {
    match access {
        Access::Real => f64::from_bits(bits).to_string(),
        Access::Float32 => (f64::from_bits(bits) as f32).to_string(),
        Access::Boolean => (bits != 0).to_string(),
        Access::UInt64 => bits.to_string(),
        _ => bits.cast_signed().to_string(),
    }
}

/// A Boolean may be any integer, not only `true` or `false`.
fn text_to_number(access: Access, text: &str) -> Option<u64> {
    match (access, text) {
        (Access::Real | Access::Float32, _) => text.parse().ok().map(f64::to_bits),
        (Access::Boolean, "true") => Some(1),
        (Access::Boolean, "false") => Some(0),
        (Access::UInt64, _) => text.parse().ok(),
        _ => text.parse().ok().map(i64::cast_unsigned),
    }
}
