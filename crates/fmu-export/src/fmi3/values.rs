//! Getting and setting variables.

use super::calls;
use super::ffi::*;
use super::instance::{Body, Fmi3, enter};
use crate::Model;
use crate::border::arguments::{Array, array, array_mut, texts};
use crate::border::log::c_string;
use crate::core::access::not_allowed;
use crate::core::fault::{Fault, refuse};
use crate::core::phase::Phase;
use crate::core::variable::{Kind, Place};

macro_rules! set_and_get {
    ($($set:ident $set_name:literal $set_call:ident $get:ident $get_name:literal $get_call:ident $c_type:ty, $from_c:expr, $to_c:expr;)*) => {$(
        #[doc = concat!($set_name, ".\n\n# Safety\nSee [`entry`](super::entry).")]
        pub unsafe fn $set<M: Model>(
            c: Instance,
            vr: *const ValueReference,
            n: usize,
            values: *const $c_type,
            n_values: usize,
        ) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M, Fmi3>(c, calls::$set_call, |b| {
                    let (vr, values) = (array("valueReferences", vr, n)?, array("values", values, n_values)?);
                    b.instance.set_blocks(|k| vr.at(k), n_values, |k| $from_c(values.get(k)))?;
                    b.note_set();
                    Ok(())
                })
            }
        }

        #[doc = concat!($get_name, ".\n\n# Safety\nSee [`entry`](super::entry).")]
        pub unsafe fn $get<M: Model>(
            c: Instance,
            vr: *const ValueReference,
            n: usize,
            values: *mut $c_type,
            n_values: usize,
        ) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M, Fmi3>(c, calls::$get_call, |b| {
                    let (vr, values) = (array("valueReferences", vr, n)?, array_mut("values", values, n_values)?);
                    b.check_update(|k| vr.at(k))?;
                    b.instance.get_blocks(|k| vr.at(k), n_values, |k, some| values.put_all(k, some, $to_c))
                })
            }
        }
    )*};
}

set_and_get! {
    set_float64 "fmi3SetFloat64" SET_FLOAT64 get_float64 "fmi3GetFloat64" GET_FLOAT64 f64, |x: f64| x, |x: f64| x;
    set_boolean "fmi3SetBoolean" SET_BOOLEAN get_boolean "fmi3GetBoolean" GET_BOOLEAN Boolean, |c: Boolean| c != 0, |value: bool| Boolean::from(value);
}

macro_rules! set_and_get_integers {
    ($($set:ident $set_name:literal $set_call:ident $get:ident $get_name:literal $get_call:ident $c_type:ty, $name:literal $enumeration:literal;)*) => {$(
        #[doc = concat!($set_name, ".\n\n# Safety\nSee [`entry`](super::entry).")]
        pub unsafe fn $set<M: Model>(
            c: Instance,
            vr: *const ValueReference,
            n: usize,
            values: *const $c_type,
            n_values: usize,
        ) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M, Fmi3>(c, calls::$set_call, |b| {
                    let (vr, values) = (array("valueReferences", vr, n)?, array("values", values, n_values)?);
                    check_integers(b, |k| vr.at(k), n_values, Some(|k| i64::from(values.get(k))), $name, $enumeration)?;
                    b.instance.set_blocks(|k| vr.at(k), n_values, |k| values.get(k) as i32)?;
                    b.note_set();
                    Ok(())
                })
            }
        }

        #[doc = concat!($get_name, ".\n\n# Safety\nSee [`entry`](super::entry).")]
        pub unsafe fn $get<M: Model>(
            c: Instance,
            vr: *const ValueReference,
            n: usize,
            values: *mut $c_type,
            n_values: usize,
        ) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M, Fmi3>(c, calls::$get_call, |b| {
                    let (vr, values) = (array("valueReferences", vr, n)?, array_mut("values", values, n_values)?);
                    b.check_update(|k| vr.at(k))?;
                    check_integers(b, |k| vr.at(k), n_values, None::<fn(usize) -> i64>, $name, $enumeration)?;
                    b.instance.get_blocks(|k| vr.at(k), n_values, |k, some: &[i32]| values.put_all(k, some, <$c_type>::from))
                })
            }
        }
    )*};
}

// Integers are of 32 bits. Enumerations, which the core keeps as integers, are set and read with 64 bits (FMI 3.0.2, section 2.2.6.2).
set_and_get_integers! {
    set_int32 "fmi3SetInt32" SET_INT32 get_int32 "fmi3GetInt32" GET_INT32 i32, "Int32" false;
    set_int64 "fmi3SetInt64" SET_INT64 get_int64 "fmi3GetInt64" GET_INT64 i64, "Int64" true;
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
fn not_settable_as<M: Model>(b: &Body<M>, number: ValueReference, name: &str) -> Result<(), Fault> {
    let (run, first, _) = b.instance.layout.block(number)?;
    let (row, names) = (run.row, b.instance.names);
    let (variable, kind, right) = (row.element_name(first), row.kind(names), row.access(names));
    refuse!("`{variable}` is {kind} and cannot be set as {name}; it must be set as {right}")
}

/// fmi3SetString.
///
/// # Safety
/// See [`entry`](super::entry).
pub unsafe fn set_string<M: Model>(
    c: Instance,
    vr: *const ValueReference,
    n: usize,
    values: *const Str,
    n_values: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::SET_STRING, |b| {
            let vr = array("valueReferences", vr, n)?;
            let values = texts("values", values, n_values)?;
            check_number_of_texts(b, vr, n, n_values)?;
            let pairs: Vec<_> = (values.iter().enumerate())
                .map(|(k, text)| (vr.get(k), *text))
                .collect();
            b.instance.set_texts(&pairs)?;
            b.note_set();
            Ok(())
        })
    }
}

/// fmi3GetString; the texts stay valid until the next call of it.
///
/// # Safety
/// See [`entry`](super::entry).
pub unsafe fn get_string<M: Model>(
    c: Instance,
    vr: *const ValueReference,
    n: usize,
    values: *mut Str,
    n_values: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::GET_STRING, |b| {
            let vr = array("valueReferences", vr, n)?;
            let values = array_mut("values", values, n_values)?;
            b.check_update(|k| vr.at(k))?;
            check_number_of_texts(b, vr, n, n_values)?;
            let mut strings = Vec::new();
            for k in 0..n {
                let (_, row) = b.instance.layout.find(vr.get(k))?;
                let is_output = matches!(row.place, Place::StringOut(_));
                if is_output && b.instance.state.phase == Phase::Instantiated {
                    b.instance.start_output(row)?;
                }
                strings.push(c_string(b.instance.text(vr.get(k))?));
            }
            b.strings = strings;
            for (k, text) in b.strings.iter().enumerate() {
                values.put(k, text.as_ptr());
            }
            Ok(())
        })
    }
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

/// Getting or setting variables of a type that no variable has.
///
/// # Safety
/// See [`entry`](super::entry).
pub(super) unsafe fn no_such_type<M: Model>(
    c: Instance,
    call: crate::border::call::Call,
    name: &str,
    is_set: bool,
    vr: *const ValueReference,
    n: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, call, |b| {
            let Some(number) = array("valueReferences", vr, n)?.at(0) else {
                return Ok(());
            };
            let (run, first, _) = b.instance.layout.block(number)?;
            match is_set {
                true => not_settable_as(b, number, name),
                false => Err(b.instance.not_gettable(run.row, first, name)),
            }
        })
    }
}
