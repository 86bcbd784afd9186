//! Getting and setting variables.
//!
//! Integers are of 32 bits. Enumerations, which the core keeps as integers, are set and read with 64 bits (FMI 3.0.2, section 2.2.6.2).

use super::ffi::*;
use super::instance::{Body, Fmi3};
use super::order::{GET, SET};
use crate::Model;
use crate::border::arguments::{Array, array, array_mut, texts};
use crate::border::functions::functions;
use crate::core::access::not_allowed;
use crate::core::fault::{Fault, refuse};
use crate::core::place::Kind;
use crate::core::value::Value;

functions! { ($) Fmi3 export_fmi3_values;
    fmi3GetFloat64 [GET] (vr: *const ValueReference, n: usize, values: *mut f64, n_values: usize)
        |b| get(b, vr, n, values, n_values, |x: f64| x);
    fmi3SetFloat64 [SET] (vr: *const ValueReference, n: usize, values: *const f64, n_values: usize)
        |b| set(b, vr, n, values, n_values, |x: f64| x);
    fmi3GetBoolean [GET] (vr: *const ValueReference, n: usize, values: *mut Boolean, n_values: usize)
        |b| get(b, vr, n, values, n_values, |x: bool| Boolean::from(x));
    fmi3SetBoolean [SET] (vr: *const ValueReference, n: usize, values: *const Boolean, n_values: usize)
        |b| set(b, vr, n, values, n_values, |x: Boolean| x != 0);
    fmi3GetInt32 [GET] (vr: *const ValueReference, n: usize, values: *mut i32, n_values: usize)
        |b| get_integers(b, vr, n, values, n_values, "Int32", false);
    fmi3SetInt32 [SET] (vr: *const ValueReference, n: usize, values: *const i32, n_values: usize)
        |b| set_integers(b, vr, n, values, n_values, "Int32", false);
    fmi3GetInt64 [GET] (vr: *const ValueReference, n: usize, values: *mut i64, n_values: usize)
        |b| get_integers(b, vr, n, values, n_values, "Int64", true);
    fmi3SetInt64 [SET] (vr: *const ValueReference, n: usize, values: *const i64, n_values: usize)
        |b| set_integers(b, vr, n, values, n_values, "Int64", true);
    /// The texts stay valid until the next call of it.
    fmi3GetString [GET] (vr: *const ValueReference, n: usize, values: *mut Str, n_values: usize)
        |b| {
            let (vr, values) = (array("valueReferences", vr, n)?, array_mut("values", values, n_values)?);
            b.check_update(|k| vr.at(k))?;
            check_number_of_texts(b, vr, n, n_values)?;
            b.get_texts(n, |k| vr.get(k), values)
        };
    fmi3SetString [SET] (vr: *const ValueReference, n: usize, values: *const Str, n_values: usize)
        |b| {
            let (vr, values) = (array("valueReferences", vr, n)?, texts("values", values, n_values)?);
            check_number_of_texts(b, vr, n, n_values)?;
            b.set_texts(|k| vr.get(k), &values)?;
            b.note_set();
            Ok(())
        };
}

/// Sets variables.
///
/// # Safety
/// See [`entry`](super::entry).
#[inline]
unsafe fn set<M: Model, C: Copy, T: Value>(
    b: &mut Body<M>,
    vr: *const ValueReference,
    n: usize,
    values: *const C,
    n_values: usize,
    from_c: impl Fn(C) -> T + Copy,
) -> Result<(), Fault> {
    // SAFETY: forwarded.
    let (vr, values) = unsafe {
        (
            array("valueReferences", vr, n)?,
            array("values", values, n_values)?,
        )
    };
    (b.instance).set_blocks(|k| vr.at(k), n_values, |k| from_c(values.get(k)))?;
    b.note_set();
    Ok(())
}

/// Gets variables.
///
/// # Safety
/// See [`entry`](super::entry).
#[inline]
unsafe fn get<M: Model, C: Copy, T: Value>(
    b: &mut Body<M>,
    vr: *const ValueReference,
    n: usize,
    values: *mut C,
    n_values: usize,
    to_c: impl Fn(T) -> C,
) -> Result<(), Fault> {
    // SAFETY: forwarded.
    let (vr, values) = unsafe {
        (
            array("valueReferences", vr, n)?,
            array_mut("values", values, n_values)?,
        )
    };
    b.check_update(|k| vr.at(k))?;
    (b.instance).get_blocks(
        |k| vr.at(k),
        n_values,
        |k, some| values.put_all(k, some, &to_c),
    )
}

/// Sets integers, or the numbers of items of enumerations.
///
/// # Safety
/// See [`entry`](super::entry).
unsafe fn set_integers<M: Model, C: Copy + Into<i64>>(
    b: &mut Body<M>,
    vr: *const ValueReference,
    n: usize,
    values: *const C,
    n_values: usize,
    name: &str,
    enumeration: bool,
) -> Result<(), Fault> {
    // SAFETY: forwarded.
    let (numbers, integers) = unsafe {
        (
            array("valueReferences", vr, n)?,
            array("values", values, n_values)?,
        )
    };
    let value = |k| integers.get(k).into();
    check_integers(
        b,
        |k| numbers.at(k),
        n_values,
        Some(value),
        name,
        enumeration,
    )?;
    // SAFETY: forwarded.
    unsafe { set(b, vr, n, values, n_values, |x: C| x.into() as i32) }
}

/// Gets integers, or the numbers of items of enumerations.
///
/// # Safety
/// See [`entry`](super::entry).
unsafe fn get_integers<M: Model, C: Copy + From<i32>>(
    b: &mut Body<M>,
    vr: *const ValueReference,
    n: usize,
    values: *mut C,
    n_values: usize,
    name: &str,
    enumeration: bool,
) -> Result<(), Fault> {
    // SAFETY: forwarded.
    let (vr, values) = unsafe {
        (
            array("valueReferences", vr, n)?,
            array_mut("values", values, n_values)?,
        )
    };
    b.check_update(|k| vr.at(k))?;
    let none = None::<fn(usize) -> i64>;
    check_integers(b, |k| vr.at(k), n_values, none, name, enumeration)?;
    (b.instance).get_blocks(
        |k| vr.at(k),
        n_values,
        |k, some: &[i32]| values.put_all(k, some, C::from),
    )
}

/// Refuses integers among enumerations and the other way round, and values that do not fit.
fn check_integers<M: Model>(
    b: &Body<M>,
    number: impl Fn(usize) -> Option<ValueReference>,
    len: usize,
    value: Option<impl Fn(usize) -> i64>,
    name: &str,
    enumeration: bool,
) -> Result<(), Fault> {
    let mut from = 0;
    for number in (0..).map_while(number) {
        let (run, first, n) = b.instance.layout.block(number)?;
        let is_integer = run.row.place.kind() == Kind::Integer;
        if is_integer && run.row.enumeration.is_some() != enumeration {
            return match &value {
                Some(_) => not_settable_as(b, number, name),
                None => Err(b.instance.not_gettable(run.row, first, name)),
            };
        }
        for k in from..(from + n).min(len) {
            let value = value.as_ref().map_or(0, |value| value(k));
            if i32::try_from(value).is_err() {
                return Err(not_allowed(run.row, first + k - from, value));
            }
        }
        from += n;
    }
    Ok(())
}

#[cold]
pub(super) fn not_settable_as<M: Model>(
    b: &Body<M>,
    number: ValueReference,
    name: &str,
) -> Result<(), Fault> {
    let (run, first, _) = b.instance.layout.block(number)?;
    let (row, names) = (run.row, b.instance.names);
    let (variable, kind, right) = (row.element_name(first), row.kind(names), row.access(names));
    refuse!("`{variable}` is {kind} and cannot be set as {name}; it must be set as {right}")
}

/// Texts are scalars; of what is no text, the type is said first.
fn check_number_of_texts<M: Model>(
    b: &Body<M>,
    vr: Array<ValueReference>,
    n: usize,
    n_values: usize,
) -> Result<(), Fault> {
    for k in 0..n {
        b.instance.layout.block(vr.get(k))?;
    }
    let is_text = |k: usize| {
        let found = b.instance.layout.find(vr.get(k));
        found.is_ok_and(|(_, row)| row.place.kind() == Kind::String)
    };
    if n != n_values && (0..n).all(is_text) {
        return refuse!(
            "nValues = {n_values} must be {n}, the number of elements of these variables"
        );
    }
    if n != n_values {
        let wrong = (0..n).find(|&k| !is_text(k)).expect("found above");
        return not_settable_as(b, vr.get(wrong), "String");
    }
    Ok(())
}
