//! Calls that get and set values of variables.

use std::ffi::{CStr, CString, c_int};
use std::ptr;

use fmi_description::Access;

use super::{Array, RawInstance, c_text, either};
use crate::functions::OwnFunctions::{self, Fmi3};
use crate::standard::Text;
use crate::status::{ABSENT, WARNING};
use crate::text;

impl RawInstance {
    /// Numbers of variables of one type, `n` of them; what the call is named. Without room it is
    /// given NULL.
    pub fn get_numbers(
        &self,
        access: Access,
        vr: Array<u32>,
        values: Option<&mut [u64]>,
        n: usize,
    ) -> (c_int, &'static str) {
        assert!(
            values
                .as_ref()
                .is_none_or(|room| room.len() >= n.max(vr.len()))
        );
        let to = values.map_or(ptr::null_mut(), <[u64]>::as_mut_ptr);
        let (c, vr, m) = (self.c, vr.pointer(), vr.len());
        // SAFETY: a live instance or NULL; room for `n` values of at most eight bytes each.
        unsafe {
            either!(self, f =>
                f.get_numbers(access, c, vr, m, to, n),
                f.get_numbers(access, c, vr, m, to, n))
        }
    }

    /// Sets numbers likewise.
    pub fn set_numbers(
        &self,
        access: Access,
        vr: Array<u32>,
        values: Option<&[u64]>,
        n: usize,
    ) -> (c_int, &'static str) {
        assert!(values.is_none_or(|values| values.len() >= n.max(vr.len())));
        let from = values.map_or(ptr::null(), <[u64]>::as_ptr);
        let (c, vr, m) = (self.c, vr.pointer(), vr.len());
        // SAFETY: a live instance or NULL; `n` values of at most eight bytes each.
        unsafe {
            either!(self, f =>
                f.set_numbers(access, c, vr, m, from, n),
                f.set_numbers(access, c, vr, m, from, n))
        }
    }

    /// Real variables, one number for each of their elements.
    pub fn get_reals(&self, vr: Array<u32>, values: Option<&mut [f64]>) -> c_int {
        let n = values.as_ref().map_or(vr.len(), |values| values.len());
        assert!(n >= vr.len());
        let to = values.map_or(ptr::null_mut(), <[f64]>::as_mut_ptr);
        let (c, vr, m) = (self.c, vr.pointer(), vr.len());
        // SAFETY: a live instance or NULL, NULL or room for `n` values.
        unsafe {
            either!(self, f =>
                (f.fmi2GetReal)(c, vr, m, to),
                (f.fmi3GetFloat64)(c, vr, m, to, n))
        }
    }

    /// Sets Real variables likewise.
    pub fn set_reals(&self, vr: Array<u32>, values: Array<f64>) -> c_int {
        let n = values.len();
        assert!(n >= vr.len());
        let (c, m, vr, from) = (self.c, vr.len(), vr.pointer(), values.pointer());
        // SAFETY: a live instance or NULL, NULL or `n` values.
        unsafe {
            either!(self, f =>
                (f.fmi2SetReal)(c, vr, m, from),
                (f.fmi3SetFloat64)(c, vr, m, from, n))
        }
    }

    /// `n` texts of String variables; None for a pointer that leads to no text.
    pub fn get_strings(&self, vr: &[u32], n: usize) -> (c_int, Option<Vec<CString>>) {
        assert!(n >= vr.len());
        let mut texts = vec![ptr::null(); n];
        let (c, m, vr, to) = (self.c, vr.len(), vr.as_ptr(), texts.as_mut_ptr());
        // SAFETY: a live instance or NULL, room for `n` texts.
        let status = unsafe {
            either!(self, f => (f.fmi2GetString)(c, vr, m, to), (f.fmi3GetString)(c, vr, m, to, n))
        };
        if status > WARNING {
            return (status, Some(vec![CString::default(); n]));
        }
        // SAFETY: what is given out is NULL or a C string until the next call.
        let owned = texts.into_iter().map(|text| unsafe { text::owned(text) });
        (status, owned.collect())
    }

    /// Sets String variables, to NULL too.
    pub fn set_strings(&self, vr: &[u32], values: &[Option<&CStr>]) -> c_int {
        assert!(values.len() >= vr.len());
        let texts: Vec<Text> = values.iter().map(|text| c_text(*text)).collect();
        let (c, m, n, vr, from) = (self.c, vr.len(), texts.len(), vr.as_ptr(), texts.as_ptr());
        // SAFETY: a live instance or NULL, NULL or C strings.
        unsafe {
            either!(self, f =>
                (f.fmi2SetString)(c, vr, m, from),
                (f.fmi3SetString)(c, vr, m, from, n))
        }
    }

    /// `n` values of Binary variables (FMI 3.0).
    pub fn get_binaries(&self, vr: &[u32], n: usize) -> (c_int, Vec<Vec<u8>>) {
        let Fmi3(f) = &self.functions.own else {
            return (ABSENT, Vec::new());
        };
        let (mut sizes, mut at) = (vec![0; n], vec![ptr::null(); n]);
        let (sizes_at, values_at) = (sizes.as_mut_ptr(), at.as_mut_ptr());
        // SAFETY: a live instance or NULL, room for all elements.
        let status =
            unsafe { (f.fmi3GetBinary)(self.c, vr.as_ptr(), vr.len(), sizes_at, values_at, n) };
        if status > WARNING {
            return (status, vec![Vec::new(); n]);
        }
        let value = |(at, size): (*const u8, usize)| match at.is_null() || size == 0 {
            true => Vec::new(),
            // SAFETY: as many bytes as the FMU says, until the next call.
            false => unsafe { std::slice::from_raw_parts(at, size) }.to_vec(),
        };
        (status, at.into_iter().zip(sizes).map(value).collect())
    }

    /// Sets Binary variables (FMI 3.0).
    pub fn set_binaries(&self, vr: &[u32], values: &[&[u8]]) -> c_int {
        let Fmi3(f) = &self.functions.own else {
            return ABSENT;
        };
        let (at, sizes): (Vec<_>, Vec<_>) = values.iter().map(|v| (v.as_ptr(), v.len())).unzip();
        let (n, sizes, at) = (at.len(), sizes.as_ptr(), at.as_ptr());
        // SAFETY: a live instance or NULL, arrays of the lengths given.
        unsafe { (f.fmi3SetBinary)(self.c, vr.as_ptr(), vr.len(), sizes, at, n) }
    }
}
