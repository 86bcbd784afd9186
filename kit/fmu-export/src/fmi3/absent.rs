//! Functions of what this FMU declares not to have: clocks, Scheduled Execution. Each is refused by
//! name, and leaves the instance as it is.

use super::ffi::*;
use super::instance::{Body, Fmi3};
use super::order::ANY;
use super::values::VR;
use crate::Model;
use crate::border::arguments::{Array, array};
use crate::border::call::{E, M, N};
use crate::border::functions::functions;
use crate::core::fault::{Fault, refuse};

const SCHEDULED: &str = "this function is for Scheduled Execution, which this FMU does not offer";

functions! { ($) Fmi3 export_fmi3_absent;
    // Clocks.
    fmi3GetClock [E | M] (vr: *const ValueReference, n: usize, values: *mut Boolean) |b| not_read(b, array(VR, vr, n)?, "Clock");
    fmi3SetClock [E | M] (vr: *const ValueReference, n: usize, values: *const Boolean) |b| not_set(b, array(VR, vr, n)?, "Clock");
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
        .map_or(Ok(()), |number| b.instance.not_settable_as(number, name))
}

/// What is for clocks only, of which there are none.
fn no_clock<M: Model>(b: &Body<M>, vr: Array<ValueReference>) -> Result<(), Fault> {
    let Some(number) = vr.at(0) else {
        return Ok(());
    };
    let (run, first, _) = b.instance.layout.block(number)?;
    let (name, kind) = (
        b.instance.name(run.row, first),
        run.row.kind(b.instance.names),
    );
    refuse!("`{name}` is {kind}; it must be a Clock, and this FMU has none")
}
