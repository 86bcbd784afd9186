//! Getting and setting variables.
//!
//! Integers are of 32 bits. Enumerations and sizes, which the core keeps as integers, are set and
//! read with 64 bits (FMI 3.0.2, section 2.2.6.2).

use super::ffi::*;
use super::instance::{Body, Fmi3};
use super::order::{GET, SET};
use crate::Model;
use crate::border::arguments::{Array, ArrayMut, array, array_mut, bytes, texts};
use crate::border::call::{C, G};
use crate::border::functions::functions;
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
    fmi3GetFloat32 [GET] (vr: *const ValueReference, n: usize, values: *mut f32, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, None, |x: f32| x);
    fmi3SetFloat32 [SET] (vr: *const ValueReference, n: usize, values: *const f32, n_values: usize)
        |b| set(b, array(VR, vr, n)?, array("values", values, n_values)?, |x: f32| x);
    fmi3GetInt8 [GET] (vr: *const ValueReference, n: usize, values: *mut i8, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, None, |x: i8| x);
    fmi3SetInt8 [SET] (vr: *const ValueReference, n: usize, values: *const i8, n_values: usize)
        |b| set(b, array(VR, vr, n)?, array("values", values, n_values)?, |x: i8| x);
    fmi3GetUInt8 [GET] (vr: *const ValueReference, n: usize, values: *mut u8, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, None, |x: u8| x);
    fmi3SetUInt8 [SET] (vr: *const ValueReference, n: usize, values: *const u8, n_values: usize)
        |b| set(b, array(VR, vr, n)?, array("values", values, n_values)?, |x: u8| x);
    fmi3GetInt16 [GET] (vr: *const ValueReference, n: usize, values: *mut i16, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, None, |x: i16| x);
    fmi3SetInt16 [SET] (vr: *const ValueReference, n: usize, values: *const i16, n_values: usize)
        |b| set(b, array(VR, vr, n)?, array("values", values, n_values)?, |x: i16| x);
    fmi3GetUInt16 [GET] (vr: *const ValueReference, n: usize, values: *mut u16, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, None, |x: u16| x);
    fmi3SetUInt16 [SET] (vr: *const ValueReference, n: usize, values: *const u16, n_values: usize)
        |b| set(b, array(VR, vr, n)?, array("values", values, n_values)?, |x: u16| x);
    fmi3GetUInt32 [GET] (vr: *const ValueReference, n: usize, values: *mut u32, n_values: usize)
        |b| get(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, None, |x: u32| x);
    fmi3SetUInt32 [SET] (vr: *const ValueReference, n: usize, values: *const u32, n_values: usize)
        |b| set(b, array(VR, vr, n)?, array("values", values, n_values)?, |x: u32| x);
    fmi3GetInt64 [GET] (vr: *const ValueReference, n: usize, values: *mut i64, n_values: usize)
        |b| get_wide(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, &INT64, i64::from);
    fmi3SetInt64 [SET] (vr: *const ValueReference, n: usize, values: *const i64, n_values: usize)
        |b| set_wide(b, array(VR, vr, n)?, array("values", values, n_values)?, &INT64);
    fmi3GetUInt64 [GET | G] (vr: *const ValueReference, n: usize, values: *mut u64, n_values: usize)
        |b| get_wide(b, array(VR, vr, n)?, array_mut("values", values, n_values)?, &UINT64, |x| x.unsigned_abs().into());
    fmi3SetUInt64 [SET | G] (vr: *const ValueReference, n: usize, values: *const u64, n_values: usize)
        |b| set_wide(b, array(VR, vr, n)?, array("values", values, n_values)?, &UINT64);
    /// The texts stay valid until the next call of it.
    fmi3GetString [GET] (vr: *const ValueReference, n: usize, values: *mut Str, n_values: usize)
        |b| {
            let (vr, values) = (array(VR, vr, n)?, array_mut("values", values, n_values)?);
            let elements = elements(b, vr, n_values, Kind::String, None::<&[String]>)?;
            b.get_texts(elements.into_iter(), values)
        };
    fmi3SetString [SET] (vr: *const ValueReference, n: usize, values: *const Str, n_values: usize)
        |b| {
            let (vr, values) = (array(VR, vr, n)?, texts("values", values, n_values)?);
            let values = values.into_iter().map(str::to_owned).collect::<Vec<_>>();
            let elements = elements(b, vr, n_values, Kind::String, Some(&values))?;
            b.instance.set_texts(elements.into_iter().zip(values).collect())?;
            b.note_set();
            Ok(())
        };
    /// The bytes stay valid until the next call of it.
    fmi3GetBinary [GET] (vr: *const ValueReference, n: usize, sizes: *mut usize, values: *mut Binary, n_values: usize)
        |b| {
            let (vr, sizes) = (array(VR, vr, n)?, array_mut("valueSizes", sizes, n_values)?);
            let values = array_mut("values", values, n_values)?;
            let elements = elements(b, vr, n_values, Kind::Binary, None::<&[crate::Binary]>)?;
            let mut found = Vec::with_capacity(elements.len());
            b.instance.get(|k| elements.get(k).copied(), |_, value: crate::Binary| found.push(value))?;
            b.bytes = found;
            for (k, value) in b.bytes.iter().enumerate() {
                sizes.put(k, value.len());
                values.put(k, value.as_ptr());
            }
            Ok(())
        };
    fmi3SetBinary [SET] (vr: *const ValueReference, n: usize, sizes: *const usize, values: *const Binary, n_values: usize)
        |b| {
            let (vr, sizes) = (array(VR, vr, n)?, array("valueSizes", sizes, n_values)?);
            let values = array("values", values, n_values)?;
            let value = |k| bytes(&format!("values[{k}]"), values.get(k), sizes.get(k)).map(crate::Binary::from);
            let given = (0..n_values).map(value).collect::<Result<Vec<_>, _>>()?;
            let elements = elements(b, vr, n_values, Kind::Binary, Some(&given))?;
            b.instance.set(|k| Some((*elements.get(k)?, given.get(k)?.clone())))?;
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
fn get<M: Model, C: Copy, T: Value + Copy>(
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
                if is_integer && !b.instance.is_settable::<i32>(run.row) {
                    let (i, value) = (first + k - from, value.to_string());
                    return Err(b.instance.not_settable(run.row, i, &value, Kind::Integer));
                }
                return Err(b.instance.not_allowed(run.row, first + k - from, value));
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
    let (variable, kind, right) = (
        b.instance.name(row, first),
        row.kind(names),
        row.access(names),
    );
    refuse!("`{variable}` is {kind} and cannot be set as {name}; it must be set as {right}")
}

/// The elements that `n_values` texts or values of Binary are for, which are `given` to be set, or
/// got.
fn elements<M: Model, T: Value>(
    b: &mut Body<M>,
    vr: Array<ValueReference>,
    n_values: usize,
    kind: Kind,
    given: Option<&[T]>,
) -> Result<Vec<u32>, Fault> {
    if given.is_none() {
        b.check_update(|k| vr.at(k))?;
    }
    let mut from = 0;
    for number in vr.iter() {
        let (run, first, n) = b.instance.layout.block(number)?;
        if run.row.place.kind() != kind {
            let name = kind.name(b.instance.names);
            return Err(match given.map(|given| given.get(from)) {
                Some(Some(value)) => b
                    .instance
                    .not_settable(run.row, first, &value.shown(), kind),
                Some(None) => return not_settable_as(b, number, name).map(|()| Vec::new()),
                None => b.instance.not_gettable(run.row, first, name),
            });
        }
        from += n;
    }
    let elements = b.elements(vr.len(), |k| vr.get(k))?;
    match elements.len() {
        n if n == n_values => Ok(elements),
        n => refuse!("nValues = {n_values} must be {n}, the number of elements of these variables"),
    }
}

/// Whether a batch is of integers of 32 bits that are set and read with 64: enumerations and sizes;
/// None if it is of some and of others.
fn is_narrow<M: Model>(b: &Body<M>, vr: Array<ValueReference>) -> Result<Option<bool>, Fault> {
    let mut found = None;
    for number in vr.iter() {
        let (run, ..) = b.instance.layout.block(number)?;
        let is_narrow = run.row.place.kind() == Kind::Integer;
        if *found.get_or_insert(is_narrow) != is_narrow {
            return Ok(None);
        }
    }
    Ok(Some(found.unwrap_or(true)))
}

/// Sets integers of 64 bits.
fn set_wide<M: Model, C: Value + Copy + Into<i128>>(
    b: &mut Body<M>,
    vr: Array<ValueReference>,
    values: Array<C>,
    integers: &Integers,
) -> Result<(), Fault> {
    match is_narrow(b, vr)? {
        Some(true) => return set_integers(b, vr, values, integers),
        Some(false) => return set(b, vr, values, |x: C| x),
        None => {}
    }
    let parts = parts(b, vr, values.len())?;
    let (before, stepping) = (b.instance.snapshot(), b.own.stepping);
    let done = parts.into_iter().try_for_each(|(number, from, n)| {
        set_wide(b, vr.part(number, 1), values.part(from, n), integers)
    });
    done.inspect_err(|_| {
        b.instance.replace(before);
        b.own.stepping = stepping;
    })
}

/// Gets integers of 64 bits; `widen` makes them of those of 32.
fn get_wide<M: Model, C: Value + Copy>(
    b: &mut Body<M>,
    vr: Array<ValueReference>,
    values: ArrayMut<C>,
    integers: &Integers,
    widen: fn(i32) -> C,
) -> Result<(), Fault> {
    match is_narrow(b, vr)? {
        Some(true) => return get(b, vr, values, Some(integers), widen),
        Some(false) => return get(b, vr, values, None, |x: C| x),
        None => {}
    }
    for (number, from, n) in parts(b, vr, values.len())? {
        get_wide(b, vr.part(number, 1), values.part(from, n), integers, widen)?;
    }
    Ok(())
}

/// Each reference of a batch: its place, the place of its first value among all, and how many
/// elements it has.
fn parts<M: Model>(
    b: &Body<M>,
    vr: Array<ValueReference>,
    len: usize,
) -> Result<Vec<(usize, usize, usize)>, Fault> {
    let (mut parts, mut from) = (Vec::new(), 0);
    for (k, number) in vr.iter().enumerate() {
        let (_, _, n) = b.instance.layout.block(number)?;
        parts.push((k, from, n));
        from += n;
    }
    match from {
        _ if from == len => Ok(parts),
        n => refuse!("nValues = {len} must be {n}, the number of elements of these variables"),
    }
}
