//! Getting and setting variables.
//!
//! Integers are of 32 bits. Enumerations and sizes, which the core keeps as integers, are set and
//! read with 64 bits (FMI 3.0.2, section 2.2.6.2).

use super::ffi::*;
use super::instance::{Body, Fmi3};
use super::order::{GET, SET};
use crate::Model;
use crate::border::arguments::{Array, ArrayMut, array, array_mut, texts};
use crate::border::call::{C, G};
use crate::border::functions::functions;
use crate::core::access::not_allowed;
use crate::core::fault::{Fault, refuse};
use crate::core::place::Kind;
use crate::core::value::Value;

functions! { ($) Fmi3 export_fmi3_values;
    fmi3GetFloat64 [GET] (vr: *const ValueReference, n: usize, values: *mut f64, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, None, |x: f64| x);
    fmi3SetFloat64 [SET | C] (vr: *const ValueReference, n: usize, values: *const f64, n_values: usize)
        |b| {
            let vr = array(VR, vr, n)?;
            b.instance.check_between_events(|k| vr.at(k))?;
            set(b, vr, array("values", values, n_values)?, |x: f64| x)
        };
    fmi3GetBoolean [GET] (vr: *const ValueReference, n: usize, values: *mut Boolean, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, None, |x: bool| Boolean::from(x));
    fmi3SetBoolean [SET] (vr: *const ValueReference, n: usize, values: *const Boolean, n_values: usize)
        |b| set(b, array(VR, vr, n)?, array("values", values, n_values)?, |x: Boolean| x != 0);
    fmi3GetInt32 [GET] (vr: *const ValueReference, n: usize, values: *mut i32, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, Some(&INT32), |x: i32| x);
    fmi3SetInt32 [SET] (vr: *const ValueReference, n: usize, values: *const i32, n_values: usize)
        |b| set_integers(b, array(VR, vr, n)?, array("values", values, n_values)?, &INT32);
    fmi3GetInt64 [GET] (vr: *const ValueReference, n: usize, values: *mut i64, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, Some(&INT64), |x: i32| i64::from(x));
    fmi3SetInt64 [SET] (vr: *const ValueReference, n: usize, values: *const i64, n_values: usize)
        |b| set_integers(b, array(VR, vr, n)?, array("values", values, n_values)?, &INT64);
    fmi3GetUInt64 [GET | G] (vr: *const ValueReference, n: usize, values: *mut u64, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, Some(&UINT64), |x: i32| x.unsigned_abs().into());
    fmi3SetUInt64 [SET | G] (vr: *const ValueReference, n: usize, values: *const u64, n_values: usize)
        |b| set_integers(b, array(VR, vr, n)?, array("values", values, n_values)?, &UINT64);
    /// The texts stay valid until the next call of it.
    fmi3GetString [GET] (vr: *const ValueReference, n: usize, values: *mut Str, n_values: usize)
        |b| {
            let (vr, values) = (array(VR, vr, n)?, array_mut("values", values, n_values)?);
            b.check_update(|k| vr.at(k))?;
            check_number_of_texts(b, vr, n_values)?;
            b.get_texts(n, |k| vr.get(k), values)
        };
    fmi3SetString [SET] (vr: *const ValueReference, n: usize, values: *const Str, n_values: usize)
        |b| {
            let (vr, values) = (array(VR, vr, n)?, texts("values", values, n_values)?);
            check_number_of_texts(b, vr, n_values)?;
            b.set_texts(|k| vr.get(k), &values)?;
            b.note_set();
            Ok(())
        };
}

/// What FMI calls the value references.
pub(super) const VR: &str = "valueReferences";

/// A type of integers, by its name, which is that of [`Variable::access`].
struct Integers(&'static str);

const INT32: Integers = Integers("Int32");
const INT64: Integers = Integers("Int64");
const UINT64: Integers = Integers("UInt64");

/// Sets variables.
#[inline(always)]
fn set<M: Model, C: Copy, T: Value>(
    b: &mut Body<M>,
    vr: Array<ValueReference>,
    values: Array<C>,
    from_c: impl Fn(C) -> T + Copy,
) -> Result<(), Fault> {
    let (vr, all) = (&vr, &values);
    (b.instance).set_blocks(
        move |k| vr.at(k),
        all.len(),
        move |k| from_c(all.get(k)),
        move || all.iter().map(from_c),
    )?;
    b.note_set();
    Ok(())
}

/// Sets integers, or the numbers of items.
fn set_integers<M: Model, C: Copy + Into<i128>>(
    b: &mut Body<M>,
    vr: Array<ValueReference>,
    values: Array<C>,
    integers: &Integers,
) -> Result<(), Fault> {
    let value = |k| values.get(k).into();
    check_integers(b, vr, values.len(), Some(value), integers)?;
    set(b, vr, values, |x: C| x.into() as i32)
}

/// Gets variables; if they are integers, of which type.
#[inline(always)]
fn get<M: Model, C: Copy, T: Value>(
    b: &mut Body<M>,
    vr: Array<ValueReference>,
    values: ArrayMut<C>,
    integers: Option<&Integers>,
    to_c: impl Fn(T) -> C + Copy,
) -> Result<(), Fault> {
    b.check_update(|k| vr.at(k))?;
    if let Some(integers) = integers {
        check_integers(b, vr, values.len(), None::<fn(usize) -> i128>, integers)?;
    }
    // Closures of a word each, so that they are handed on in registers.
    let (vr, to) = (&vr, &values);
    (b.instance).get_blocks(
        move |k| vr.at(k),
        to.len(),
        move |k, some| to.put_all(k, some, to_c),
    )
}

/// Refuses integers among enumerations and the other way round, and values that do not fit.
fn check_integers<M: Model>(
    b: &Body<M>,
    vr: Array<ValueReference>,
    len: usize,
    value: Option<impl Fn(usize) -> i128>,
    &Integers(name): &Integers,
) -> Result<(), Fault> {
    let mut from = 0;
    for number in (0..vr.len()).map(|k| vr.get(k)) {
        let (run, first, n) = b.instance.layout.block(number)?;
        let is_integer = run.row.place.kind() == Kind::Integer;
        if is_integer && run.row.access(b.instance.names) != name {
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
    n_values: usize,
) -> Result<(), Fault> {
    let n = vr.len();
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
