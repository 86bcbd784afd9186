//! The functions of FMI 3.0 with which importers get and set variables, for each type.
//!
//! Enumerations and sizes, which the core stores with 32 bits, are set and read with 64 bits (FMI
//! 3.0.2, section 2.2.6.2).

use super::ffi::*;
use super::instance::{Fmi3, Fmi3Instance};
use super::states::{GET, SET};
use crate::Model;
use crate::c_api::arguments::{Array, ArrayMut, array, array_mut, bytes, bytes_of, texts};
use crate::c_api::call_order::{CONFIGURATION_MODE, CONTINUOUS_TIME_MODE};
use crate::c_api::functions::functions;
use crate::core::fault::{Fault, OF_VARIABLES, check_number};
use crate::core::number_access::Numbers;
use crate::core::storage::Kind;

functions! { ($) Fmi3 export_fmi3_values;
    fmi3GetFloat64 [GET] (vr: *const ValueReference, n: usize, values: *mut f64, n_values: usize)
        |fmi| {
            let (vr, to) = (array(VR, vr, n)?, array_mut("values", values, n_values)?);
            fmi.check_update(|k| vr.at(k))?;
            // References keep each closure at one word, so that it is passed in registers.
            let (vr, to) = (&vr, &to);
            (fmi.instance).get_blocks(move |k| vr.at(k), to.len(), move |k, some| to.put_all(k, some, |x| x))
        };
    fmi3SetFloat64 [SET | CONTINUOUS_TIME_MODE] (vr: *const ValueReference, n: usize, values: *const f64, n_values: usize)
        |fmi| {
            let vr = array(VR, vr, n)?;
            fmi.instance.check_between_events(|k| vr.at(k))?;
            fmi.check_clocks(|k| vr.at(k), "set")?;
            let (vr, all) = (&vr, &array("values", values, n_values)?);
            (fmi.instance).set_blocks(move |k| vr.at(k), all.len(), move |k| all.get(k), move || all.iter())?;
            fmi.note_set();
            Ok(())
        };
    /// The texts stay valid until its next call.
    fmi3GetString [GET] (vr: *const ValueReference, n: usize, values: *mut Str, n_values: usize)
        |fmi| {
            let (vr, values) = (array(VR, vr, n)?, array_mut("values", values, n_values)?);
            fmi.check_update(|k| vr.at(k))?;
            let elements = elements(fmi, vr, n_values)?;
            fmi.get_texts(elements.into_iter(), values)
        };
    fmi3SetString [SET] (vr: *const ValueReference, n: usize, values: *const Str, n_values: usize)
        |fmi| {
            let (vr, values) = (array(VR, vr, n)?, texts("values", values, n_values)?);
            fmi.check_clocks(|k| vr.at(k), "set")?;
            let elements = elements(fmi, vr, n_values)?;
            fmi.set_texts(elements.into_iter(), &values)?;
            fmi.note_set();
            Ok(())
        };
    /// The bytes stay valid until its next call.
    fmi3GetBinary [GET] (vr: *const ValueReference, n: usize, sizes: *mut usize, values: *mut Binary, n_values: usize)
        |fmi| {
            let (vr, sizes) = (array(VR, vr, n)?, array_mut("valueSizes", sizes, n_values)?);
            let values = array_mut("values", values, n_values)?;
            fmi.check_update(|k| vr.at(k))?;
            let elements = elements(fmi, vr, n_values)?;
            let mut found = Vec::with_capacity(elements.len());
            fmi.instance.get(|k| elements.get(k).copied(), |_, value: crate::Binary| found.push(value))?;
            fmi.bytes = found;
            for (k, value) in fmi.bytes.iter().enumerate() {
                sizes.put(k, value.len());
                values.put(k, value.as_ptr());
            }
            Ok(())
        };
    fmi3SetBinary [SET] (vr: *const ValueReference, n: usize, sizes: *const usize, values: *const Binary, n_values: usize)
        |fmi| {
            let (vr, sizes) = (array(VR, vr, n)?, array("valueSizes", sizes, n_values)?);
            fmi.check_clocks(|k| vr.at(k), "set")?;
            let values = array("values", values, n_values)?;
            let value = |k| bytes(&format!("values[{k}]"), values.get(k), sizes.get(k)).map(crate::Binary::from);
            let given = (0..n_values).map(value).collect::<Result<Vec<_>, _>>()?;
            let elements = elements(fmi, vr, n_values)?;
            fmi.instance.set(|k| Some((*elements.get(k)?, given.get(k)?.clone())))?;
            fmi.note_set();
            Ok(())
        };
}

/// The functions of each numeric type except Float64, which has faster ones above.
macro_rules! numbers {
    (($d:tt) $export:ident; $($kind:ident $type:ty: $get:ident $may_get:tt $set:ident $may_set:tt;)*) => {
        functions! { ($d) Fmi3 $export; $(
            $get $may_get (vr: *const ValueReference, n: usize, values: *mut $type, n_values: usize)
                |fmi| get(fmi, Kind::$kind, array(VR, vr, n)?, array_mut("values", values, n_values)?);
            $set $may_set (vr: *const ValueReference, n: usize, values: *const $type, n_values: usize)
                |fmi| set(fmi, Kind::$kind, array(VR, vr, n)?, bytes_of("values", values, n_values)?);
        )* }
    };
}

numbers! { ($) export_fmi3_numbers;
    Boolean Boolean: fmi3GetBoolean [GET] fmi3SetBoolean [SET];
    Float32 f32: fmi3GetFloat32 [GET] fmi3SetFloat32 [SET];
    Int8 i8: fmi3GetInt8 [GET] fmi3SetInt8 [SET];
    UInt8 u8: fmi3GetUInt8 [GET] fmi3SetUInt8 [SET];
    Int16 i16: fmi3GetInt16 [GET] fmi3SetInt16 [SET];
    UInt16 u16: fmi3GetUInt16 [GET] fmi3SetUInt16 [SET];
    Integer i32: fmi3GetInt32 [GET] fmi3SetInt32 [SET];
    UInt32 u32: fmi3GetUInt32 [GET] fmi3SetUInt32 [SET];
    Int64 i64: fmi3GetInt64 [GET] fmi3SetInt64 [SET];
    UInt64 u64: fmi3GetUInt64 [GET | CONFIGURATION_MODE] fmi3SetUInt64 [SET | CONFIGURATION_MODE];
}

/// Gets numbers of a kind.
fn get<M: Model, C: Copy>(
    fmi: &mut Fmi3Instance<M>,
    kind: Kind,
    vr: Array<ValueReference>,
    to: ArrayMut<C>,
) -> Result<(), Fault> {
    fmi.check_update(|k| vr.at(k))?;
    let put = &mut |k, bytes: &[u8]| to.put_bytes(k, bytes);
    (fmi.instance).get_numbers(kind, &|k| vr.at(k), to.len(), put)
}

/// Sets numbers of a kind, which are in `bytes`.
fn set<M: Model>(
    fmi: &mut Fmi3Instance<M>,
    kind: Kind,
    vr: Array<ValueReference>,
    bytes: &[u8],
) -> Result<(), Fault> {
    fmi.check_clocks(|k| vr.at(k), "set")?;
    (fmi.instance).set_numbers(&|k| vr.at(k), Numbers::new(kind, bytes))?;
    fmi.note_set();
    Ok(())
}

/// Name of the argument with the value references.
pub(super) const VR: &str = "valueReferences";

/// The elements of variables; there must be `n_values`.
fn elements<M: Model>(
    fmi: &Fmi3Instance<M>,
    vr: Array<ValueReference>,
    n_values: usize,
) -> Result<Vec<u32>, Fault> {
    let elements = fmi.elements(vr.len(), |k| vr.get(k))?;
    check_number("nValues", n_values, elements.len(), OF_VARIABLES)?;
    Ok(elements)
}
