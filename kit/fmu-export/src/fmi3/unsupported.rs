//! The functions of FMI 3.0 for clocks and Scheduled Execution, which these FMUs do not support: an
//! importer's call is refused with an error, and the instance stays as it is.

use super::ffi::*;
use super::instance::{Fmi3, Fmi3Instance};
use super::states::{ANY, EVENT_MODE};
use super::values::VR;
use crate::Model;
use crate::c_api::arguments::{Array, array};
use crate::c_api::call_order::INITIALIZATION_MODE;
use crate::c_api::functions::functions;
use crate::core::fault::{Fault, refuse};

const SCHEDULED: &str = "this function is for Scheduled Execution, which this FMU does not offer";

functions! { ($) Fmi3 export_fmi3_absent;
    // Clocks.
    fmi3GetClock [EVENT_MODE] (vr: *const ValueReference, n: usize, values: *mut Boolean) |fmi| not_read(fmi, array(VR, vr, n)?);
    fmi3SetClock [EVENT_MODE] (vr: *const ValueReference, n: usize, values: *const Boolean) |fmi| not_set(fmi, array(VR, vr, n)?);
    fmi3GetIntervalDecimal [INITIALIZATION_MODE | EVENT_MODE] (vr: *const ValueReference, n: usize, intervals: *mut f64, qualifiers: *mut c_int)
        |fmi| no_clock(fmi, array(VR, vr, n)?);
    fmi3GetIntervalFraction [INITIALIZATION_MODE | EVENT_MODE] (
        vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut c_int
    ) |fmi| no_clock(fmi, array(VR, vr, n)?);
    fmi3GetShiftDecimal [INITIALIZATION_MODE] (vr: *const ValueReference, n: usize, shifts: *mut f64) |fmi| no_clock(fmi, array(VR, vr, n)?);
    fmi3GetShiftFraction [INITIALIZATION_MODE] (vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64)
        |fmi| no_clock(fmi, array(VR, vr, n)?);
    fmi3SetIntervalDecimal [INITIALIZATION_MODE | EVENT_MODE] (vr: *const ValueReference, n: usize, intervals: *const f64) |fmi| no_clock(fmi, array(VR, vr, n)?);
    fmi3SetIntervalFraction [INITIALIZATION_MODE | EVENT_MODE] (vr: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64)
        |fmi| no_clock(fmi, array(VR, vr, n)?);
    fmi3SetShiftDecimal [INITIALIZATION_MODE | EVENT_MODE] (vr: *const ValueReference, n: usize, shifts: *const f64) |fmi| no_clock(fmi, array(VR, vr, n)?);
    fmi3SetShiftFraction [INITIALIZATION_MODE | EVENT_MODE] (vr: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64)
        |fmi| no_clock(fmi, array(VR, vr, n)?);

    // Scheduled Execution.
    fmi3ActivateModelPartition [ANY] (clock: ValueReference, time: f64) |_| refuse!("{SCHEDULED}");
}

/// Refuses to read variables as clocks, because no variable is one.
fn not_read<M: Model>(fmi: &Fmi3Instance<M>, vr: Array<ValueReference>) -> Result<(), Fault> {
    let Some(number) = vr.at(0) else {
        return Ok(());
    };
    let (span, first, _) = fmi.instance.layout.block(number)?;
    Err(fmi.instance.not_gettable(span.row, first, "Clock"))
}

/// Refuses to set variables as clocks.
fn not_set<M: Model>(fmi: &Fmi3Instance<M>, vr: Array<ValueReference>) -> Result<(), Fault> {
    let refuse = |number| fmi.instance.not_settable_as(number, "Clock");
    vr.at(0).map_or(Ok(()), refuse)
}

/// Refuses a function for clocks.
fn no_clock<M: Model>(fmi: &Fmi3Instance<M>, vr: Array<ValueReference>) -> Result<(), Fault> {
    let Some(number) = vr.at(0) else {
        return Ok(());
    };
    let (span, first, _) = fmi.instance.layout.block(number)?;
    let name = fmi.instance.name(span.row, first);
    let kind = span.row.kind(fmi.instance.names);
    refuse!("`{name}` is {kind}; it must be a Clock, and this FMU has none")
}
