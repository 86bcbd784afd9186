//! Raw arguments of C functions.
//!
//! Arrays of the importer stay raw: they may be uninitialised where we write, one array may be
//! given for several arguments, and on 32-bit platforms numbers of eight bytes may lie at multiples
//! of four. So elements are read and written one by one, through pointers, unaligned.

use crate::core::fault::{Fault, refuse};
use std::ffi::{CStr, c_char};

/// An array to read.
#[derive(Clone, Copy)]
pub(crate) struct Array<T>(*const T, usize);

/// An array to write.
#[derive(Clone, Copy)]
pub(crate) struct ArrayMut<T>(*mut T, usize);

impl<T: Copy> Array<T> {
    /// The `k`-th element; None beyond the end.
    #[inline]
    pub(crate) fn at(self, k: usize) -> Option<T> {
        // SAFETY: within the array, which `array` was promised to be readable during the call.
        (k < self.1).then(|| unsafe { self.0.add(k).read_unaligned() })
    }

    /// How many elements there are.
    #[inline]
    pub(crate) fn len(self) -> usize {
        self.1
    }

    /// All elements, one after the other.
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

    /// Writes elements from the `k`-th on.
    #[inline]
    pub(crate) fn put_all<S: Copy>(self, k: usize, values: &[S], convert: impl Fn(S) -> T) {
        assert!(k <= self.1 && values.len() <= self.1 - k);
        for (j, value) in values.iter().enumerate() {
            // SAFETY: within the array, which `array_mut` was promised to be writable during the
            // call.
            unsafe { self.0.add(k + j).write_unaligned(convert(*value)) }
        }
    }
}

impl<T> ArrayMut<T> {
    /// How many elements there are.
    #[inline]
    pub(crate) fn len(self) -> usize {
        self.1
    }

    /// Writes the bytes of elements from the `k`-th on.
    pub(crate) fn put_bytes(self, k: usize, bytes: &[u8]) {
        assert!(k <= self.1 && bytes.len() <= (self.1 - k) * size_of::<T>());
        // SAFETY: within the array, which `array_mut` was promised to be writable during the call;
        // `bytes` are ours.
        unsafe {
            bytes
                .as_ptr()
                .copy_to_nonoverlapping(self.0.add(k).cast(), bytes.len())
        }
    }
}

/// A C array to read; empty may be NULL.
///
/// # Safety
/// `p` is NULL or points at `n` values that are readable as long as the result is used.
#[inline]
pub(crate) unsafe fn array<T>(name: &str, p: *const T, n: usize) -> Result<Array<T>, Fault> {
    check(name, p, n)?;
    Ok(Array(p, n))
}

/// A C array to write; empty may be NULL.
///
/// # Safety
/// `p` is NULL or points at `n` places that are writable as long as the result is used.
#[inline]
pub(crate) unsafe fn array_mut<T>(name: &str, p: *mut T, n: usize) -> Result<ArrayMut<T>, Fault> {
    check(name, p, n)?;
    Ok(ArrayMut(p, n))
}

/// A place for one result.
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
    refuse!("{name} = NULL must be a place for the result")
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

/// Out of line, so that the arguments stay in registers.
#[cold]
#[inline(never)]
fn not_an_array<T>(name: &str, p: *const T, n: usize) -> Result<(), Fault> {
    if p.is_null() {
        return refuse!("{name} = NULL with {n} elements; NULL must come with 0 elements");
    }
    refuse!("{name} = {p:?} with {n} elements is longer than memory")
}

/// Bytes to read.
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

/// The bytes of a C array to read.
///
/// # Safety
/// As for [`bytes`].
pub(crate) unsafe fn bytes_of<'a, T>(name: &str, p: *const T, n: usize) -> Result<&'a [u8], Fault> {
    check(name, p, n)?;
    // SAFETY: not longer than memory; the rest is forwarded.
    unsafe { bytes(name, p.cast(), n * size_of::<T>()) }
}

/// C strings as text.
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
