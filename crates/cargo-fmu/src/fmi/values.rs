//! Values and derivatives of either version, by the types of FMI 2.0.

use std::ffi::c_int;
use std::ptr;

use fmu_description::Access;

use super::functions::OwnFunctions::{Fmi2, Fmi3};
use super::functions::{Functions, both};
use super::symbols::{DISCARD, Pointer, Text, WARNING};

/// # Safety
/// Gets `count` values through an array of another type; NULL stays NULL.
unsafe fn get_as<T: Copy + Default>(
    values: *mut c_int,
    count: usize,
    convert: impl Fn(T) -> c_int,
    get: impl FnOnce(*mut T, usize) -> c_int,
) -> c_int {
    if values.is_null() {
        return get(ptr::null_mut(), count);
    }
    let mut room = vec![T::default(); count];
    let status = get(room.as_mut_ptr(), count);
    if status <= WARNING {
        for (k, value) in room.into_iter().enumerate() {
            // SAFETY: room for `count` values.
            unsafe { values.add(k).write(convert(value)) };
        }
    }
    status
}

/// Sets `count` values through an array of another type; NULL stays NULL.
unsafe fn set_as<T>(
    values: *const c_int,
    count: usize,
    convert: impl Fn(c_int) -> T,
    set: impl FnOnce(*const T, usize) -> c_int,
) -> c_int {
    if values.is_null() {
        return set(ptr::null(), count);
    }
    // SAFETY: `count` values.
    let converted = (0..count).map(|k| convert(unsafe { *values.add(k) }));
    set(converted.collect::<Vec<_>>().as_ptr(), count)
}

/// As for [`Functions`].
#[allow(missing_docs, clippy::missing_safety_doc, clippy::too_many_arguments)] // named and explained in the standard
impl Functions {
    // FMI 3.0 is told the number of values, too.
    both! { self, f:
        fn get_real(c: Pointer, vr: *const u32, n: usize, values: *mut f64) -> c_int
            = (f.fmi2GetReal)(c, vr, n, values),
            (f.fmi3GetFloat64)(c, vr, n, values, self.counted(vr, n));
        fn set_real(c: Pointer, vr: *const u32, n: usize, values: *const f64) -> c_int
            = (f.fmi2SetReal)(c, vr, n, values),
            (f.fmi3SetFloat64)(c, vr, n, values, self.counted(vr, n));
        fn get_string(c: Pointer, vr: *const u32, n: usize, values: *mut Text) -> c_int
            = (f.fmi2GetString)(c, vr, n, values),
            (f.fmi3GetString)(c, vr, n, values, self.counted(vr, n));
        fn set_string(c: Pointer, vr: *const u32, n: usize, values: *const Text) -> c_int
            = (f.fmi2SetString)(c, vr, n, values),
            (f.fmi3SetString)(c, vr, n, values, self.counted(vr, n));
        fn get_output_derivatives(
            c: Pointer, vr: *const u32, n: usize, order: *const c_int, values: *mut f64
        ) -> c_int
            = (f.fmi2GetRealOutputDerivatives)(c, vr, n, order, values),
            (f.fmi3GetOutputDerivatives)(c, vr, n, order, values, self.counted(vr, n));
        /// Not in FMI 3.0, where nothing is called.
        fn set_input_derivatives(
            c: Pointer, vr: *const u32, n: usize, order: *const c_int, values: *const f64
        ) -> c_int
            = (f.fmi2SetRealInputDerivatives)(c, vr, n, order, values), DISCARD;
        fn get_directional_derivative(
            c: Pointer, unknown: *const u32, n: usize, known: *const u32, m: usize,
            seed: *const f64, result: *mut f64
        ) -> c_int
            = (f.fmi2GetDirectionalDerivative)(c, unknown, n, known, m, seed, result),
            (f.fmi3GetDirectionalDerivative)(
                c, unknown, n, known, m,
                seed, self.counted(known, m), result, self.counted(unknown, n)
            );
    }

    /// Integers, or Booleans as 0 and 1. In FMI 3.0 integers by fmi3GetInt32 where the first
    /// reference is that of an Int32, by fmi3GetUInt64 where it is that of a UInt64, else by
    /// fmi3GetInt64; a value beyond an int is its bound.
    pub unsafe fn get_integers(
        &self,
        are_booleans: bool,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *mut c_int,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            let counted = self.counted(vr, n);
            match (&self.own, are_booleans) {
                (Fmi2(f), true) => (f.fmi2GetBoolean)(c, vr, n, values),
                (Fmi2(f), false) => (f.fmi2GetInteger)(c, vr, n, values),
                (Fmi3(f), true) => {
                    let truth = |v: u8| (v != 0).into(); // an FMU may write what is no bool
                    let get =
                        |place: *mut u8, count| (f.fmi3GetBoolean)(c, vr, n, place.cast(), count);
                    get_as(values, counted, truth, get)
                }
                (Fmi3(f), false) if self.is_of(Access::Integer, references(vr, n)) => {
                    (f.fmi3GetInt32)(c, vr, n, values, counted)
                }
                (Fmi3(f), false) if self.is_of(Access::UInt64, references(vr, n)) => {
                    let narrow = |v: u64| c_int::try_from(v).unwrap_or(c_int::MAX);
                    let get = |place, count| (f.fmi3GetUInt64)(c, vr, n, place, count);
                    get_as(values, counted, narrow, get)
                }
                (Fmi3(f), false) => {
                    let narrow = |v: i64| v.clamp(c_int::MIN.into(), c_int::MAX.into()) as c_int;
                    let get = |place, count| (f.fmi3GetInt64)(c, vr, n, place, count);
                    get_as(values, counted, narrow, get)
                }
            }
        }
    }

    /// As [`Functions::get_integers`].
    pub unsafe fn set_integers(
        &self,
        are_booleans: bool,
        c: Pointer,
        vr: *const u32,
        n: usize,
        values: *const c_int,
    ) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            let counted = self.counted(vr, n);
            match (&self.own, are_booleans) {
                (Fmi2(f), true) => (f.fmi2SetBoolean)(c, vr, n, values),
                (Fmi2(f), false) => (f.fmi2SetInteger)(c, vr, n, values),
                (Fmi3(f), true) => {
                    let set = |place, count| (f.fmi3SetBoolean)(c, vr, n, place, count);
                    set_as(values, counted, |v| v != 0, set)
                }
                (Fmi3(f), false) if self.is_of(Access::Integer, references(vr, n)) => {
                    (f.fmi3SetInt32)(c, vr, n, values, counted)
                }
                (Fmi3(f), false) => {
                    let set = |place, count| (f.fmi3SetInt64)(c, vr, n, place, count);
                    set_as(values, counted, i64::from, set)
                }
            }
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
