//! The C border: raw arguments in, status out. Nothing here knows what a function does.

use crate::calls::Call;
use crate::failure::{Failure, refuse};
use crate::ffi::*;
use crate::instance::Instance;
use crate::log::Category;
use crate::{Model, panic};
use std::ffi::CStr;
use std::slice;

/// Runs `f` on the instance: NULL, poison, call order, panics and messages are dealt with here.
///
/// # Safety
/// `c` is NULL or came from fmi2Instantiate of this library, was not freed, and is not used by another thread meanwhile.
#[inline]
pub(crate) unsafe fn enter<M: Model>(
    c: Component,
    call: Call,
    f: impl FnOnce(&mut Instance<M>) -> Result<(), Failure>,
) -> Status {
    // SAFETY: forwarded.
    let Some(instance) = (unsafe { c.cast::<Instance<M>>().as_mut() }) else {
        return Status::Error;
    };
    if instance.poisoned {
        return Status::Fatal;
    }
    let result = panic::catch(|| {
        call.check(instance.state.mode)?;
        f(instance)
    });
    match result {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(failure)) => report(instance, call, failure),
        Err(message) => poison(instance, call, &message),
    }
}

#[cold]
fn report<M: Model>(instance: &Instance<M>, call: Call, failure: Failure) -> Status {
    let (category, status, text) = match failure {
        Failure::Error(text) => (Category::Error, Status::Error, text),
        Failure::Discard(text) => (Category::Discard, Status::Discard, text),
    };
    instance
        .log
        .send(category, &format!("{}: {text}", call.name));
    status
}

#[cold]
fn poison<M: Model>(instance: &mut Instance<M>, call: Call, message: &str) -> Status {
    instance.poisoned = true;
    let text = format!("{}: {message}; this instance can only be freed", call.name);
    instance.log.send(Category::Fatal, &text);
    Status::Fatal
}

/// A C array to read; empty may be NULL.
///
/// # Safety
/// `p` is NULL or points at `n` readable values.
#[inline]
pub(crate) unsafe fn array<'a, T>(name: &str, p: *const T, n: usize) -> Result<&'a [T], Failure> {
    if n == 0 {
        return Ok(&[]);
    }
    check_array::<T>(name, p, n)?;
    // SAFETY: not NULL, aligned, not longer than memory; the rest is forwarded.
    Ok(unsafe { slice::from_raw_parts(p, n) })
}

/// A C array to write; empty may be NULL.
///
/// # Safety
/// `p` is NULL or points at `n` writable values that nothing else refers to.
#[inline]
pub(crate) unsafe fn array_mut<'a, T>(
    name: &str,
    p: *mut T,
    n: usize,
) -> Result<&'a mut [T], Failure> {
    if n == 0 {
        return Ok(&mut []);
    }
    check_array::<T>(name, p, n)?;
    // SAFETY: not NULL, aligned, not longer than memory; the rest is forwarded.
    Ok(unsafe { slice::from_raw_parts_mut(p, n) })
}

#[inline]
fn check_array<T>(name: &str, p: *const T, n: usize) -> Result<(), Failure> {
    if p.is_null() {
        return refuse!("{name} = NULL with {n} elements; allowed is NULL with 0 elements only");
    }
    if !p.is_aligned() || n > isize::MAX as usize / size_of::<T>() {
        return refuse!("{name} = {p:?} with {n} elements is no array");
    }
    Ok(())
}

/// A place for one result.
///
/// # Safety
/// As for [`array_mut`], with one value.
pub(crate) unsafe fn place<'a, T>(name: &str, p: *mut T) -> Result<&'a mut T, Failure> {
    if p.is_null() || !p.is_aligned() {
        return refuse!("{name} = {p:?}; allowed is a place for the result");
    }
    // SAFETY: not NULL, aligned; the rest is forwarded.
    Ok(unsafe { &mut *p })
}

/// C strings as text.
///
/// # Safety
/// As for [`array`]; each element is NULL or a C string.
pub(crate) unsafe fn texts<'a>(
    name: &str,
    p: *const Str,
    n: usize,
) -> Result<Vec<&'a str>, Failure> {
    // SAFETY: forwarded.
    let strings = unsafe { array(name, p, n) }?;
    let text = |(i, s): (usize, &Str)| {
        if s.is_null() {
            return refuse!("{name}[{i}] = NULL; allowed are strings");
        }
        // SAFETY: not NULL, hence a C string.
        let s = unsafe { CStr::from_ptr(*s) };
        s.to_str()
            .map_err(|_| Failure::Error(format!("{name}[{i}] = {s:?} is not UTF-8")))
    };
    strings.iter().enumerate().map(text).collect()
}
