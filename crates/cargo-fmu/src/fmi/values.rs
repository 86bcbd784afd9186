//! Values and derivatives of either version, by the types of FMI 2.0.

use super::functions::Own::{Fmi2, Fmi3};
use super::functions::{DISCARD, Functions, Pointer, Text, WARNING};
use std::ffi::c_int;
use std::ptr;

/// # Safety
/// As for [`Functions`].
#[allow(missing_docs, clippy::missing_safety_doc, clippy::too_many_arguments)] // named and explained in the standard
impl Functions {
    pub unsafe fn get_real(&self, c: Pointer, vr: *const u32, n: usize, values: *mut f64) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2GetReal)(c, vr, n, values),
                Fmi3(f) => (f.fmi3GetFloat64)(c, vr, n, values, self.counted(vr, n)),
            }
        }
    }

    pub unsafe fn set_real(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *const f64,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2SetReal)(c, vr, n, values),
                Fmi3(f) => (f.fmi3SetFloat64)(c, vr, n, values, self.counted(vr, n)),
            }
        }
    }

    /// In FMI 3.0 by fmi3GetInt32 where the first reference is that of an Int32, else by fmi3GetInt64; a value beyond an int is its bound.
    pub unsafe fn get_integer(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *mut c_int,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2GetInteger)(c, vr, n, values),
                Fmi3(f) if self.is_int32(references(vr, n)) => {
                    (f.fmi3GetInt32)(c, vr, n, values, self.counted(vr, n))
                }
                Fmi3(f) => {
                    let mut wide = vec![0_i64; self.counted(vr, n)];
                    let place = if values.is_null() {
                        ptr::null_mut()
                    } else {
                        wide.as_mut_ptr()
                    };
                    let status = (f.fmi3GetInt64)(c, vr, n, place, wide.len());
                    if status <= WARNING && !values.is_null() {
                        let narrow =
                            |v: &i64| (*v).clamp(c_int::MIN.into(), c_int::MAX.into()) as c_int;
                        wide.iter()
                            .enumerate()
                            .for_each(|(k, v)| values.add(k).write(narrow(v)));
                    }
                    status
                }
            }
        }
    }

    /// As [`Functions::get_integer`].
    pub unsafe fn set_integer(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *const c_int,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2SetInteger)(c, vr, n, values),
                Fmi3(f) if self.is_int32(references(vr, n)) => {
                    (f.fmi3SetInt32)(c, vr, n, values, self.counted(vr, n))
                }
                Fmi3(f) => {
                    let count = self.counted(vr, n);
                    let wide: Vec<i64> = match values.is_null() {
                        true => Vec::new(),
                        false => (0..count).map(|k| (*values.add(k)).into()).collect(),
                    };
                    let place = if values.is_null() {
                        ptr::null()
                    } else {
                        wide.as_ptr()
                    };
                    (f.fmi3SetInt64)(c, vr, n, place, count)
                }
            }
        }
    }

    pub unsafe fn get_boolean(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *mut c_int,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2GetBoolean)(c, vr, n, values),
                Fmi3(f) => {
                    let mut narrow = vec![false; self.counted(vr, n)];
                    let place = if values.is_null() {
                        ptr::null_mut()
                    } else {
                        narrow.as_mut_ptr()
                    };
                    let status = (f.fmi3GetBoolean)(c, vr, n, place, narrow.len());
                    if status <= WARNING && !values.is_null() {
                        narrow
                            .iter()
                            .enumerate()
                            .for_each(|(k, v)| values.add(k).write((*v).into()));
                    }
                    status
                }
            }
        }
    }

    pub unsafe fn set_boolean(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *const c_int,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2SetBoolean)(c, vr, n, values),
                Fmi3(f) => {
                    let count = self.counted(vr, n);
                    let narrow: Vec<bool> = match values.is_null() {
                        true => Vec::new(),
                        false => (0..count).map(|k| *values.add(k) != 0).collect(),
                    };
                    let place = if values.is_null() {
                        ptr::null()
                    } else {
                        narrow.as_ptr()
                    };
                    (f.fmi3SetBoolean)(c, vr, n, place, count)
                }
            }
        }
    }

    pub unsafe fn get_string(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *mut Text,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2GetString)(c, vr, n, values),
                Fmi3(f) => (f.fmi3GetString)(c, vr, n, values, self.counted(vr, n)),
            }
        }
    }

    pub unsafe fn set_string(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *const Text,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2SetString)(c, vr, n, values),
                Fmi3(f) => (f.fmi3SetString)(c, vr, n, values, self.counted(vr, n)),
            }
        }
    }

    pub unsafe fn get_directional_derivative(
        &self,
        c: Pointer,
        unknown: *const u32,
        n_unknown: usize,
        known: *const u32,
        n_known: usize,
        seed: *const f64,
        result: *mut f64,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2GetDirectionalDerivative)(
                    c, unknown, n_unknown, known, n_known, seed, result,
                ),
                Fmi3(f) => {
                    let (seeds, results) = (
                        self.counted(known, n_known),
                        self.counted(unknown, n_unknown),
                    );
                    (f.fmi3GetDirectionalDerivative)(
                        c, unknown, n_unknown, known, n_known, seed, seeds, result, results,
                    )
                }
            }
        }
    }

    pub unsafe fn get_output_derivatives(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        order: *const c_int,
        values: *mut f64,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => (f.fmi2GetRealOutputDerivatives)(c, vr, n, order, values),
                Fmi3(f) => {
                    (f.fmi3GetOutputDerivatives)(c, vr, n, order, values, self.counted(vr, n))
                }
            }
        }
    }

    /// Not in FMI 3.0, where nothing is called.
    pub unsafe fn set_input_derivatives(
        &self,
        c: Pointer,
        vr: *const u32,
        n: usize,
        order: *const c_int,
        values: *const f64,
    ) -> c_int {
        match &self.own {
            // SAFETY: forwarded.
            Fmi2(f) => unsafe { (f.fmi2SetRealInputDerivatives)(c, vr, n, order, values) },
            Fmi3(_) => DISCARD,
        }
    }
}

unsafe fn references<'a>(vr: *const u32, n: usize) -> &'a [u32] {
    match vr.is_null() {
        true => &[],
        // SAFETY: `n` references.
        false => unsafe { std::slice::from_raw_parts(vr, n) },
    }
}
