//! Checked access to C arguments (arrays, strings, results), for functions of both FMI versions.
//!
//! No Rust slices are made of the importer's arrays: an output array may be uninitialised, one
//! array may be passed for several arguments, and on 32-bit platforms eight-byte numbers may be
//! aligned to four bytes. Elements are read and written one by one, unaligned, through pointers.

use crate::core::fault::{Fault, refuse};
use std::ffi::{CStr, c_char};

/// An array of the importer to read.
#[derive(Clone, Copy)]
pub(crate) struct Array<T>(*const T, usize);

/// An array of the importer to write.
#[derive(Clone, Copy)]
pub(crate) struct ArrayMut<T>(*mut T, usize);

impl<T: Copy> Array<T> {
    /// The `k`-th element; None beyond the end.
    #[inline]
    pub(crate) fn at(self, k: usize) -> Option<T> {
        // SAFETY: within the array, which `array` was promised to be readable during the call.
        (k < self.1).then(|| unsafe { self.0.add(k).read_unaligned() })
    }

    /// The number of elements.
    #[inline]
    pub(crate) fn len(self) -> usize {
        self.1
    }

    /// All elements in order.
    #[inline]
    pub(crate) fn iter(self) -> impl Iterator<Item = T> {
        // SAFETY: as in `at`.
        (0..self.1).map(move |k| unsafe { self.0.add(k).read_unaligned() })
    }

    /// The `k`-th element, which must exist.
    #[inline]
    pub(crate) fn get(self, k: usize) -> T {
        self.at(k).expect("an element of the array")
    }
}

impl<T: Copy> ArrayMut<T> {
    /// Writes the `k`-th element.
    #[inline]
    pub(crate) fn put(self, k: usize, value: T) {
        assert!(k < self.1);
        // SAFETY: within the array, which `array_mut` was promised to be writable during the call.
        unsafe { self.0.add(k).write_unaligned(value) }
    }

    /// Writes `values`, converted, starting at the `k`-th element.
    #[inline]
    pub(crate) fn put_all<S: Copy>(self, k: usize, values: &[S], convert: impl Fn(S) -> T) {
        assert!(k <= self.1 && values.len() <= self.1 - k);
        for (j, value) in values.iter().enumerate() {
            // SAFETY: within the array, which `array_mut` was promised to be writable.
            unsafe { self.0.add(k + j).write_unaligned(convert(*value)) }
        }
    }
}

impl<T> ArrayMut<T> {
    /// The number of elements.
    #[inline]
    pub(crate) fn len(self) -> usize {
        self.1
    }

    /// Writes the bytes of elements, starting at the `k`-th element.
    pub(crate) fn put_bytes(self, k: usize, bytes: &[u8]) {
        assert!(k <= self.1 && bytes.len() <= (self.1 - k) * size_of::<T>());
        // SAFETY: within the array, which was promised to be writable; `bytes` are ours.
        unsafe {
            bytes
                .as_ptr()
                .copy_to_nonoverlapping(self.0.add(k).cast(), bytes.len())
        }
    }
}

/// Checks a C array to read; NULL is allowed for 0 elements.
///
/// # Safety
/// `p` is NULL or points at `n` values that are readable as long as the result is used.
#[inline]
pub(crate) unsafe fn array<T>(name: &str, p: *const T, n: usize) -> Result<Array<T>, Fault> {
    check(name, p, n)?;
    Ok(Array(p, n))
}

/// Checks a C array to write; NULL is allowed for 0 elements.
///
/// # Safety
/// `p` is NULL or points at `n` places that are writable as long as the result is used.
#[inline]
pub(crate) unsafe fn array_mut<T>(name: &str, p: *mut T, n: usize) -> Result<ArrayMut<T>, Fault> {
    check(name, p, n)?;
    Ok(ArrayMut(p, n))
}

/// Checks a pointer through which one result is returned.
///
/// # Safety
/// As for [`array_mut`], with one value.
#[inline]
pub(crate) unsafe fn output_argument<T>(name: &str, p: *mut T) -> Result<ArrayMut<T>, Fault> {
    if p.is_null() {
        return null_output(name);
    }
    Ok(ArrayMut(p, 1))
}

#[cold]
#[inline(never)]
fn null_output<T>(name: &str) -> Result<ArrayMut<T>, Fault> {
    refuse!("{name} = NULL must be a pointer for the result")
}

#[inline]
fn check<T>(name: &str, p: *const T, n: usize) -> Result<(), Fault> {
    let is_sound = n == 0 || !p.is_null() && n <= isize::MAX as usize / size_of::<T>();
    if is_sound {
        Ok(())
    } else {
        not_an_array(name, p, n)
    }
}

/// The error of [`check`], out of line so that the arguments stay in registers.
#[cold]
#[inline(never)]
fn not_an_array<T>(name: &str, p: *const T, n: usize) -> Result<(), Fault> {
    if p.is_null() {
        return refuse!("{name} = NULL with {n} elements; NULL must come with 0 elements");
    }
    refuse!("{name} = {p:?} with {n} elements is longer than memory")
}

/// A C array of bytes as a slice.
///
/// # Safety
/// As for [`array`]; nothing writes to them as long as the result is used.
pub(crate) unsafe fn bytes<'a>(name: &str, p: *const u8, n: usize) -> Result<&'a [u8], Fault> {
    check(name, p, n)?;
    if n == 0 {
        return Ok(&[]);
    }
    // SAFETY: not NULL, not longer than memory; the rest is forwarded.
    Ok(unsafe { std::slice::from_raw_parts(p, n) })
}

/// The bytes of a C array of any type as a slice.
///
/// # Safety
/// As for [`bytes`].
pub(crate) unsafe fn bytes_of<'a, T>(name: &str, p: *const T, n: usize) -> Result<&'a [u8], Fault> {
    check(name, p, n)?;
    // SAFETY: not longer than memory; the rest is forwarded.
    unsafe { bytes(name, p.cast(), n * size_of::<T>()) }
}

/// An array of C strings as texts.
///
/// # Safety
/// As for [`array`]; each element is NULL or a C string.
pub(crate) unsafe fn texts<'a>(
    name: &str,
    p: *const *const c_char,
    n: usize,
) -> Result<Vec<&'a str>, Fault> {
    // SAFETY: forwarded.
    let strings = unsafe { array(name, p, n) }?;
    let text = |i: usize| {
        let s = strings.get(i);
        if s.is_null() {
            return refuse!("{name}[{i}] = NULL must be a string");
        }
        // SAFETY: not NULL, hence a C string.
        let s = unsafe { CStr::from_ptr(s) };
        s.to_str()
            .map_err(|_| Fault::Refused(format!("{name}[{i}] = {s:?} is not UTF-8")))
    };
    (0..n).map(text).collect()
}
