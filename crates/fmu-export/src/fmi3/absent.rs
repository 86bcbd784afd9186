//! Functions of what this FMU declares not to have: variables of other types, clocks, Scheduled
//! Execution. Each is refused by name, and leaves the
//! instance as it is.

use super::ffi::*;
use super::instance::{Body, Fmi3};
use super::order::{ANY, GET, SET};
use super::values::{VR, not_settable_as};
use crate::Model;
use crate::border::arguments::{Array, array};
use crate::border::call::{E, M, N};
use crate::border::functions::functions;
use crate::core::fault::{Fault, refuse};

const SCHEDULED: &str = "this function is for Scheduled Execution, which this FMU does not offer";

functions! { ($) Fmi3 export_fmi3_absent;
    // Types that no variable has.
    fmi3GetFloat32 [GET] (vr: *const ValueReference, n: usize, values: *mut f32, n_values: usize) |b| not_read(b, array(VR, vr, n)?, "Float32");
    fmi3GetInt8 [GET] (vr: *const ValueReference, n: usize, values: *mut i8, n_values: usize) |b| not_read(b, array(VR, vr, n)?, "Int8");
    fmi3GetUInt8 [GET] (vr: *const ValueReference, n: usize, values: *mut u8, n_values: usize) |b| not_read(b, array(VR, vr, n)?, "UInt8");
    fmi3GetInt16 [GET] (vr: *const ValueReference, n: usize, values: *mut i16, n_values: usize) |b| not_read(b, array(VR, vr, n)?, "Int16");
    fmi3GetUInt16 [GET] (vr: *const ValueReference, n: usize, values: *mut u16, n_values: usize) |b| not_read(b, array(VR, vr, n)?, "UInt16");
    fmi3GetUInt32 [GET] (vr: *const ValueReference, n: usize, values: *mut u32, n_values: usize) |b| not_read(b, array(VR, vr, n)?, "UInt32");
    fmi3GetBinary [GET] (vr: *const ValueReference, n: usize, sizes: *mut usize, values: *mut Binary, n_values: usize)
        |b| not_read(b, array(VR, vr, n)?, "Binary");
    fmi3GetClock [E | M] (vr: *const ValueReference, n: usize, values: *mut Boolean) |b| not_read(b, array(VR, vr, n)?, "Clock");
    fmi3SetFloat32 [SET] (vr: *const ValueReference, n: usize, values: *const f32, n_values: usize) |b| not_set(b, array(VR, vr, n)?, "Float32");
    fmi3SetInt8 [SET] (vr: *const ValueReference, n: usize, values: *const i8, n_values: usize) |b| not_set(b, array(VR, vr, n)?, "Int8");
    fmi3SetUInt8 [SET] (vr: *const ValueReference, n: usize, values: *const u8, n_values: usize) |b| not_set(b, array(VR, vr, n)?, "UInt8");
    fmi3SetInt16 [SET] (vr: *const ValueReference, n: usize, values: *const i16, n_values: usize) |b| not_set(b, array(VR, vr, n)?, "Int16");
    fmi3SetUInt16 [SET] (vr: *const ValueReference, n: usize, values: *const u16, n_values: usize) |b| not_set(b, array(VR, vr, n)?, "UInt16");
    fmi3SetUInt32 [SET] (vr: *const ValueReference, n: usize, values: *const u32, n_values: usize) |b| not_set(b, array(VR, vr, n)?, "UInt32");
    fmi3SetBinary [SET] (vr: *const ValueReference, n: usize, sizes: *const usize, values: *const Binary, n_values: usize)
        |b| not_set(b, array(VR, vr, n)?, "Binary");
    fmi3SetClock [E | M] (vr: *const ValueReference, n: usize, values: *const Boolean) |b| not_set(b, array(VR, vr, n)?, "Clock");

    // Clocks.
    fmi3GetIntervalDecimal [N | E | M] (vr: *const ValueReference, n: usize, intervals: *mut f64, qualifiers: *mut c_int)
        |b| no_clock(b, array(VR, vr, n)?);
    fmi3GetIntervalFraction [N | E | M] (
        vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut c_int
    ) |b| no_clock(b, array(VR, vr, n)?);
    fmi3GetShiftDecimal [N] (vr: *const ValueReference, n: usize, shifts: *mut f64) |b| no_clock(b, array(VR, vr, n)?);
    fmi3GetShiftFraction [N] (vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64)
        |b| no_clock(b, array(VR, vr, n)?);
    fmi3SetIntervalDecimal [N | E | M] (vr: *const ValueReference, n: usize, intervals: *const f64) |b| no_clock(b, array(VR, vr, n)?);
    fmi3SetIntervalFraction [N | E | M] (vr: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64)
        |b| no_clock(b, array(VR, vr, n)?);
    fmi3SetShiftDecimal [N | E | M] (vr: *const ValueReference, n: usize, shifts: *const f64) |b| no_clock(b, array(VR, vr, n)?);
    fmi3SetShiftFraction [N | E | M] (vr: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64)
        |b| no_clock(b, array(VR, vr, n)?);

    // Scheduled Execution.
    fmi3ActivateModelPartition [ANY] (clock: ValueReference, time: f64) |_| refuse!("{SCHEDULED}");
}

/// Reading variables as a type that none of them has.
fn not_read<M: Model>(b: &Body<M>, vr: Array<ValueReference>, name: &str) -> Result<(), Fault> {
    let Some(number) = vr.at(0) else {
        return Ok(());
    };
    let (run, first, _) = b.instance.layout.block(number)?;
    Err(b.instance.not_gettable(run.row, first, name))
}

/// Setting variables as a type that none of them has.
fn not_set<M: Model>(b: &Body<M>, vr: Array<ValueReference>, name: &str) -> Result<(), Fault> {
    vr.at(0)
        .map_or(Ok(()), |number| not_settable_as(b, number, name))
}

/// What is for clocks only, of which there are none.
fn no_clock<M: Model>(b: &Body<M>, vr: Array<ValueReference>) -> Result<(), Fault> {
    let Some(number) = vr.at(0) else {
        return Ok(());
    };
    let (run, first, _) = b.instance.layout.block(number)?;
    let (name, kind) = (run.row.element_name(first), run.row.kind(b.instance.names));
    refuse!("`{name}` is {kind}; it must be a Clock, and this FMU has none")
}
