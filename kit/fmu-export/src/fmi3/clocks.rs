//! The functions of FMI 3.0 for clocks and Scheduled Execution (FMI 3.0.2, sections 2.2.9 and 5.2).
//! Intervals are passed as decimals; fractions are refused, since no clock has `supportsFraction`.

use super::ffi::*;
use super::instance::{Fmi3, Fmi3Instance, Schedule};
use super::states::{CLOCK_ACTIVATION, EVENT_MODE};
use super::values::VR;
use crate::Model;
use crate::c_api::arguments::{Array, array, array_mut};
use crate::c_api::call_order::{Call, INITIALIZATION_MODE, SE};
use crate::c_api::export::Exported;
use crate::c_api::fmi_instance::enter;
use crate::c_api::functions::functions;
use crate::core::fault::{Fault, refuse};

/// Where intervals are read.
const INTERVAL: u16 = INITIALIZATION_MODE | EVENT_MODE | CLOCK_ACTIVATION;

functions! { ($) Fmi3 export_fmi3_clocks;
    fmi3GetClock [EVENT_MODE | CLOCK_ACTIVATION] (vr: *const ValueReference, n: usize, values: *mut Boolean)
        |fmi| {
            let (vr, to) = (array(VR, vr, n)?, array_mut("values", values, n)?);
            each(fmi, vr, |fmi, k, number| {
                to.put(k, fmi.instance.get_clock(number)?.into());
                Ok(())
            })
        };
    fmi3SetClock [EVENT_MODE] (vr: *const ValueReference, n: usize, values: *const Boolean)
        |fmi| {
            let (vr, values) = (array(VR, vr, n)?, array("values", values, n)?);
            each(fmi, vr, |fmi, _, number| fmi.instance.input_clock(number).map(drop))?;
            each(fmi, vr, |fmi, k, number| fmi.instance.set_clock(number, values.get(k) != 0))
        };
    fmi3GetIntervalDecimal [INTERVAL] (vr: *const ValueReference, n: usize, intervals: *mut f64, qualifiers: *mut c_int)
        |fmi| {
            let (vr, to) = (array(VR, vr, n)?, array_mut("intervals", intervals, n)?);
            let qualifiers = array_mut("qualifiers", qualifiers, n)?;
            each(fmi, vr, |fmi, k, number| {
                let (interval, qualifier) = fmi.instance.interval(number)?;
                if !interval.is_nan() {
                    to.put(k, interval);
                }
                qualifiers.put(k, qualifier as c_int);
                Ok(())
            })
        };
    fmi3GetShiftDecimal [INITIALIZATION_MODE] (vr: *const ValueReference, n: usize, shifts: *mut f64)
        |fmi| {
            let (vr, to) = (array(VR, vr, n)?, array_mut("shifts", shifts, n)?);
            each(fmi, vr, |fmi, k, number| {
                to.put(k, fmi.instance.shift(number)?);
                Ok(())
            })
        };
    fmi3SetIntervalDecimal [INTERVAL] (vr: *const ValueReference, n: usize, intervals: *const f64)
        |fmi| {
            let (vr, intervals) = (array(VR, vr, n)?, array("intervals", intervals, n)?);
            each(fmi, vr, |fmi, k, number| fmi.instance.set_interval(number, intervals.get(k)))
        };
    fmi3SetShiftDecimal [INTERVAL] (vr: *const ValueReference, n: usize, shifts: *const f64)
        |fmi| each(fmi, array(VR, vr, n)?, |fmi, _, number| not(fmi, number, "its shift cannot be set"));
    fmi3GetIntervalFraction [INTERVAL] (
        vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut c_int
    ) |fmi| each(fmi, array(VR, vr, n)?, |fmi, _, number| not(fmi, number, NO_FRACTION));
    fmi3GetShiftFraction [INITIALIZATION_MODE] (vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64)
        |fmi| each(fmi, array(VR, vr, n)?, |fmi, _, number| not(fmi, number, NO_FRACTION));
    fmi3SetIntervalFraction [INTERVAL] (vr: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64)
        |fmi| each(fmi, array(VR, vr, n)?, |fmi, _, number| not(fmi, number, NO_FRACTION));
    fmi3SetShiftFraction [INTERVAL] (vr: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64)
        |fmi| each(fmi, array(VR, vr, n)?, |fmi, _, number| not(fmi, number, NO_FRACTION));
}

const NO_FRACTION: &str =
    "it does not support fractions; use the function with Decimal in its name";

/// Calls `f` with the index and number of each clock.
fn each<M: Model>(
    fmi: &mut Fmi3Instance<M>,
    vr: Array<ValueReference>,
    f: impl Fn(&mut Fmi3Instance<M>, usize, u32) -> Result<(), Fault>,
) -> Result<(), Fault> {
    vr.iter()
        .try_for_each(|number| fmi.instance.clock(number).map(drop))?;
    vr.iter()
        .enumerate()
        .try_for_each(|(k, number)| f(fmi, k, number))
}

/// Refuses something of a clock.
fn not<M: Model>(fmi: &Fmi3Instance<M>, number: u32, reason: &str) -> Result<(), Fault> {
    let name = M::CLOCKS[fmi.instance.clock(number)?].row.name;
    refuse!("clock `{name}`: {reason}")
}

const ACTIVATE: Call = Call::new("fmi3ActivateModelPartition", SE | CLOCK_ACTIVATION);

/// fmi3ActivateModelPartition. Preemption is locked meanwhile: a model is not computed by two
/// threads at once. At its end it tells the importer of clocks that have ticked or been started.
///
/// # Safety
/// As for every function of [`entry`](super::entry).
#[expect(non_snake_case, reason = "the name of FMI")]
pub unsafe fn fmi3ActivateModelPartition<X: Exported>(
    c: Instance,
    clock: ValueReference,
    time: f64,
) -> Status {
    let mut schedule = None;
    // SAFETY: forwarded.
    let status = unsafe {
        enter::<X::Model, Fmi3>(c, ACTIVATE, |fmi| {
            schedule.clone_from(&fmi.version.schedule);
            Ok(())
        })
    };
    let Some(schedule) = schedule else {
        return status;
    };
    let Schedule {
        lock,
        unlock,
        clock_update,
        environment,
    } = schedule;
    let mut has_news = false;
    // SAFETY: the importer's callbacks, called while no reference to the instance exists.
    unsafe {
        if let Some(lock) = lock {
            lock();
        }
        let status = enter::<X::Model, Fmi3>(c, ACTIVATE, |fmi| {
            has_news = fmi.instance.activate(clock, time)?;
            Ok(())
        });
        if let Some(unlock) = unlock {
            unlock();
        }
        if let Some(update) = clock_update.filter(|_| has_news) {
            update(environment);
        }
        status
    }
}
