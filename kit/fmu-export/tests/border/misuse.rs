//! Wrong arguments: fmi2Error, or fmi2Discard for values; a message with name, value and what it
//! must be; nothing changed.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;
use std::ptr;

/// Checks that `wrong` is refused with `text` in the message and changes nothing that can be saved.
fn refused(fmu: &Fmu, text: &str, wrong: impl FnOnce() -> Status) {
    answered(fmu, (Status::Error, "logStatusError"), text, wrong);
}

/// The same for values: fmi2Error would be the end of the instance (FMI 2.0.4, section 2.1.3).
fn discarded(fmu: &Fmu, text: &str, wrong: impl FnOnce() -> Status) {
    answered(fmu, (Status::Discard, "logStatusDiscard"), text, wrong);
}

fn answered(
    fmu: &Fmu,
    (status, category): (Status, &str),
    text: &str,
    wrong: impl FnOnce() -> Status,
) {
    let before = fmu.snapshot();
    assert_eq!(wrong(), status, "{text}");
    let message = fmu.last();
    assert!(
        message.text.contains(text),
        "`{}` lacks `{text}`",
        message.text
    );
    assert_eq!(
        (message.status, message.category.as_str()),
        (status, category)
    );
    assert_eq!(fmu.snapshot(), before, "{text}");
}

#[test]
fn reals_out_of_place_are_refused() {
    let fmu = Fmu::stepping();
    #[rustfmt::skip]
    let calls = [
        (vr::COUNT,   1.0,               "fmi2SetReal: unknown value reference 18; it must be from 0 to 17"),
        (u32::MAX,    1.0,               "unknown value reference 4294967295; it must be from 0 to 17"),
        (vr::GAIN,    9.0,               "gain = 9 is for nobody"),
        (vr::RATE[1], 1.0,               "`rate[2]` = 1: a Real fixed parameter cannot be set any more; it must be set before the end of initialization"),
        (vr::X[1],    1.0,               "`x[2]` = 1: a Real output cannot be set; only inputs and parameters can"),
        (vr::INNER,   1.0,               "`inner` = 1: a Real local variable cannot be set; only inputs and parameters can"),
        (vr::LAW,     1.0,               "`law` = 1: an Integer fixed parameter cannot be set as Real; it must be set as Integer"),
        (vr::SWITCH,  1.0,               "`switch` = 1: a Boolean input cannot be set as Real; it must be set as Boolean"),
        (vr::FILE,    1.0,               "`file` = 1: a String fixed parameter cannot be set as Real; it must be set as String"),
    ];
    #[rustfmt::skip]
    let values = [
        (vr::U[1],    f64::NAN,          "`u[2]` = NaN must be finite and at least -1000000"),
        (vr::U[0],    f64::INFINITY,     "`u[1]` = inf must be finite and at least -1000000"),
        (vr::HELD,    f64::NEG_INFINITY, "`held` = -inf must be finite"),
        (vr::U[0],    -1000001.0,        "`u[1]` = -1000001 must be finite and at least -1000000"),
        (vr::GAIN,    10.000001,         "`gain` = 10.000001 must be from 0 to 10"),
        (vr::GAIN,    -0.5,              "`gain` = -0.5 must be from 0 to 10"),
    ];
    // The rest of the batch is right, and must not be written either.
    let set = |wrong, value| fmu.set(&[vr::U[0], vr::GAIN, wrong], &[2.0, 4.0, value]);
    for (wrong, value, text) in calls {
        refused(&fmu, text, || set(wrong, value));
    }
    for (wrong, value, text) in values {
        discarded(&fmu, text, || set(wrong, value));
    }
}

#[test]
fn integers_booleans_and_strings_out_of_place_are_refused() {
    let fmu = Fmu::initializing();
    #[rustfmt::skip]
    let values = [
        (vr::LAW,   0,  "`law` = 0 must be 1 (plain) or 2 (other)"),
        (vr::LAW,   3,  "`law` = 3 must be 1 (plain) or 2 (other)"),
        (vr::LEVEL, 8,  "`level` = 8 must be from -3 to 7"),
        (vr::LEVEL, -4, "`level` = -4 must be from -3 to 7"),
    ];
    #[rustfmt::skip]
    let calls = [
        (vr::GAIN,  1,  "`gain` = 1: a Real tunable parameter cannot be set as Integer; it must be set as Real"),
        (99,        1,  "unknown value reference 99"),
    ];
    for (wrong, value, text) in values {
        discarded(&fmu, text, || fmu.set_integer(wrong, value));
    }
    for (wrong, value, text) in calls {
        refused(&fmu, text, || fmu.set_integer(wrong, value));
    }
    refused(&fmu, "`on` = true: a Boolean output cannot be set", || {
        fmu.set_boolean(vr::ON, 1)
    });
    refused(
        &fmu,
        "`u[1]` = false: a Real input cannot be set as Boolean",
        || fmu.set_boolean(vr::U[0], 0),
    );
    refused(
        &fmu,
        "`file` = \"x\": invalid digit found in string; it must be a number",
        || fmu.set_string(vr::FILE, c"x"),
    );
    refused(&fmu, "value[0] = \"\\xff\" is not UTF-8", || {
        fmu.set_string(vr::FILE, c"\xff")
    });
    refused(
        &fmu,
        "`gain` = \"x\": a Real tunable parameter cannot be set as String",
        || fmu.set_string(vr::GAIN, c"x"),
    );
    // SAFETY: one value reference, one NULL string.
    refused(&fmu, "value[0] = NULL must be a string", || unsafe {
        fmi2SetString(fmu.c, &vr::FILE, 1, &ptr::null())
    });
}

#[test]
fn reading_with_the_wrong_function_is_refused() {
    let fmu = Fmu::stepping();
    refused(
        &fmu,
        "`law` is an Integer fixed parameter and cannot be read as Real; it must be read as Integer",
        || fmu.try_get(vr::LAW),
    );
    refused(
        &fmu,
        "fmi2GetReal: unknown value reference 18; it must be from 0 to 17",
        || fmu.try_get(vr::COUNT),
    );
    // SAFETY: one value reference and one place each.
    unsafe {
        refused(
            &fmu,
            "`x[1]` is a Real output and cannot be read as Integer",
            || fmi2GetInteger(fmu.c, &vr::X[0], 1, &mut 0),
        );
        refused(
            &fmu,
            "`file` is a String fixed parameter and cannot be read as Boolean",
            || fmi2GetBoolean(fmu.c, &vr::FILE, 1, &mut 0),
        );
        refused(
            &fmu,
            "`gain` is a Real tunable parameter and cannot be read as String",
            || fmi2GetString(fmu.c, &vr::GAIN, 1, &mut ptr::null()),
        );
    }
}

#[test]
fn null_arrays_are_refused() {
    let fmu = Fmu::stepping();
    let (c, vr) = (fmu.c, &vr::U[0]);
    // SAFETY: NULL is what is tested; everything else has one element.
    unsafe {
        refused(
            &fmu,
            "vr = NULL with 1 elements; NULL must come with 0 elements",
            || fmi2SetReal(c, ptr::null(), 1, &1.0),
        );
        refused(&fmu, "value = NULL with 1 elements", || {
            fmi2SetReal(c, vr, 1, ptr::null())
        });
        refused(&fmu, "value = NULL with 1 elements", || {
            fmi2GetReal(c, vr, 1, ptr::null_mut())
        });
        refused(&fmu, "elements is longer than memory", || {
            fmi2SetReal(c, vr, usize::MAX, &1.0)
        });
        refused(&fmu, "order = NULL with 1 elements", || {
            fmi2SetRealInputDerivatives(c, vr, 1, ptr::null(), &1.0)
        });
        refused(&fmu, "dvKnown = NULL with 1 elements", || {
            fmi2GetDirectionalDerivative(c, vr, 1, vr, 1, ptr::null(), &mut 0.0)
        });
        refused(&fmu, "categories = NULL with 2 elements", || {
            fmi2SetDebugLogging(c, 1, 2, ptr::null())
        });
        refused(
            &fmu,
            "FMUstate = NULL must be a pointer for the result",
            || fmi2GetFMUstate(c, ptr::null_mut()),
        );
        refused(&fmu, "value = NULL must be a pointer", || {
            fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, ptr::null_mut())
        });
        refused(
            &fmu,
            "value = NULL must be a pointer for the result",
            || fmi2GetStringStatus(c, PENDING_STATUS, ptr::null_mut()),
        );
        assert_eq!(fmi2FreeFMUstate(c, ptr::null_mut()), Status::Ok);
    }
}

#[test]
fn experiments_without_sense_are_refused() {
    let fmu = Fmu::instantiated();
    // SAFETY: a live instance.
    let setup = |tolerance: Option<f64>, start, stop: Option<f64>| unsafe {
        let (t, s) = (tolerance.unwrap_or(0.0), stop.unwrap_or(0.0));
        fmi2SetupExperiment(
            fmu.c,
            tolerance.is_some().into(),
            t,
            start,
            stop.is_some().into(),
            s,
        )
    };
    refused(&fmu, "start time = NaN s must be finite", || {
        setup(None, f64::NAN, None)
    });
    refused(
        &fmu,
        "stop time = 1 s must be at least the start time = 2 s",
        || setup(None, 2.0, Some(1.0)),
    );
    refused(&fmu, "stop time = NaN s", || {
        setup(None, 2.0, Some(f64::NAN))
    });
    // No stop time at all; and a tolerance is a wish that this FMU has no use for, whatever it is.
    assert_eq!(setup(None, 2.0, Some(f64::INFINITY)), Status::Ok);
    for tolerance in [0.0, -1.0, f64::NAN, 1e-6] {
        assert_eq!(setup(Some(tolerance), 2.0, None), Status::Ok);
    }
    assert_eq!(setup(Some(1e-6), 2.0, Some(2.0)), Status::Ok);
}

#[test]
fn an_initialization_the_model_refuses_can_be_mended() {
    let fmu = Fmu::initializing();
    assert_eq!(fmu.set_integer(vr::LEVEL, 6), Status::Ok);
    refused(
        &fmu,
        "fmi2ExitInitializationMode: level = 6 is for nobody",
        || fmu.call(fmi2ExitInitializationMode),
    );
    refused(&fmu, "fmi2GetReal: level = 6 is for nobody", || {
        fmu.try_get(vr::Y)
    });
    assert_eq!(fmu.set_integer(vr::LEVEL, 5), Status::Ok);
    fmu.start();
}

#[test]
fn outputs_are_never_nan_and_a_failed_output_is_an_error() {
    let fmu = Fmu::stepping();
    assert_eq!(fmu.set_integer(vr::FAULT, 6), Status::Ok);
    refused(&fmu, "`y` became NaN; it must be finite", || {
        fmu.try_get(vr::Y)
    });
    assert_eq!(fmu.get(vr::X), [0.0, 0.25]);
    assert_eq!(fmu.set_integer(vr::FAULT, 5), Status::Ok);
    refused(&fmu, "fmi2GetReal: no output for fault = 5", || {
        fmu.try_get(vr::X[0])
    });
    assert_eq!(fmu.set_integer(vr::FAULT, 0), Status::Ok);
    assert_eq!(fmu.get([vr::Y]), [0.0]);
}

#[test]
fn inquiries_of_the_wrong_kind_are_discarded() {
    let fmu = Fmu::stepping();
    // "fmi2Discard: … the slave does not support this" (FMI 2.0.4, section 4.2.3). SAFETY: a live
    // instance, one place each.
    unsafe {
        discarded(&fmu, "status kind = 2 must be 0 (fmi2DoStepStatus)", || {
            fmi2GetStatus(fmu.c, LAST_SUCCESSFUL_TIME, &mut Status::Ok)
        });
        discarded(
            &fmu,
            "status kind = -5 must be 2 (fmi2LastSuccessfulTime)",
            || fmi2GetRealStatus(fmu.c, -5, &mut 0.0),
        );
        discarded(
            &fmu,
            "status kind = 0: FMI 2.0 has no Integer status",
            || fmi2GetIntegerStatus(fmu.c, 0, &mut 0),
        );
        discarded(&fmu, "status kind = 9 must be 3 (fmi2Terminated)", || {
            fmi2GetBooleanStatus(fmu.c, 9, &mut 0)
        });
        discarded(
            &fmu,
            "status kind = 0 must be 1 (fmi2PendingStatus)",
            || fmi2GetStringStatus(fmu.c, 0, &mut ptr::null()),
        );
        discarded(&fmu, "no step is pending: steps are synchronous", || {
            fmi2GetStringStatus(fmu.c, PENDING_STATUS, &mut ptr::null())
        });
    }
    refused(&fmu, "no step is in progress", || fmu.call(fmi2CancelStep));
}
