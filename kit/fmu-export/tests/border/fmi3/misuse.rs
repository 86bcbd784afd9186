//! Wrong arguments: fmi3Error, or fmi3Discard for values; a message with name, value and what it
//! must be; nothing changed.

use crate::client3::*;
use crate::probe::vr;
use std::ptr;

const TIME: u32 = 65536;

fn refused(fmu: &Fmu3, text: &str, wrong: impl FnOnce() -> Status) {
    answered(fmu, (Status::Error, "logStatusError"), text, wrong);
}

fn discarded(fmu: &Fmu3, text: &str, wrong: impl FnOnce() -> Status) {
    answered(fmu, (Status::Discard, "logStatusDiscard"), text, wrong);
}

fn answered(
    fmu: &Fmu3,
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
fn numbers_out_of_place_are_refused() {
    let fmu = Fmu3::initialized(EVENTS);
    #[rustfmt::skip]
    let calls: &[(&[u32], &[f64], &str)] = &[
        (&[vr::COUNT],   &[1.0],      "fmi3SetFloat64: unknown value reference 18; it must be from 0 to 17"),
        (&[vr::U[1]],    &[1.0],      "unknown value reference 8; it must be one of the model description"),
        (&[TIME],        &[1.0],      "value reference 65536 is `time`"),
        (&[vr::GAIN],    &[9.0],      "gain = 9 is for nobody"),
        (&[vr::RATE[0]], &[1.0, 2.0], "`rate[1]` = 1: a Float64 fixed parameter cannot be set any more; it must be set before the end of initialization"),
        (&[vr::X[0]],    &[1.0, 2.0], "`x[1]` = 1: a Float64 output cannot be set; only inputs and parameters can"),
        (&[vr::LAW],     &[1.0],      "`law` = 1: an Enumeration fixed parameter cannot be set as Float64; it must be set as Int64"),
        (&[vr::LEVEL],   &[1.0],      "`level` = 1: an Int32 fixed parameter cannot be set as Float64; it must be set as Int32"),
        (&[vr::SWITCH],  &[1.0],      "`switch` = 1: a Boolean input cannot be set as Float64; it must be set as Boolean"),
        (&[vr::U[0]],    &[1.0],      "nValues = 1 is less than the number of elements of these variables"),
        (&[vr::U[0]],    &[1.0; 3],   "nValues = 3 must be 2, the number of elements of these variables"),
        (&[],            &[1.0],      "nValues = 1 must be 0, the number of elements of these variables"),
    ];
    for (vr, values, text) in calls {
        refused(&fmu, text, || fmu.set(vr, values));
    }
    #[rustfmt::skip]
    let values = [
        (vr::U[0], vec![0.0, f64::NAN],   "`u[2]` = NaN must be finite and at least -1000000"),
        (vr::U[0], vec![-1000001.0, 0.0], "`u[1]` = -1000001 must be finite and at least -1000000"),
        (vr::HELD, vec![f64::INFINITY],   "`held` = inf must be finite"),
        (vr::GAIN, vec![10.5],            "`gain` = 10.5 must be from 0 to 10"),
    ];
    for (wrong, values, text) in values {
        // The rest of the batch is right, and must not be written either.
        let all = [vec![2.0, 3.0], values].concat();
        discarded(&fmu, text, || fmu.set(&[vr::U[0], wrong], &all));
    }
}

#[test]
fn other_types_out_of_place_are_refused() {
    let fmu = Fmu3::initializing(PLAIN);
    discarded(&fmu, "`law` = 3 must be 1 (plain) or 2 (other)", || {
        fmu.set_int64(vr::LAW, 3)
    });
    discarded(
        &fmu,
        "`law` = 4294967297 must be 1 (plain) or 2 (other)",
        || fmu.set_int64(vr::LAW, 1 + (1 << 32)),
    );
    discarded(&fmu, "`level` = 8 must be from -3 to 7", || {
        fmu.set_int32(vr::LEVEL, 8)
    });
    refused(
        &fmu,
        "`law` is an Enumeration fixed parameter and cannot be set as Int32; it must be set as Int64",
        || fmu.set_int32(vr::LAW, 1),
    );
    refused(
        &fmu,
        "`level` = 1: an Int32 fixed parameter cannot be set as Int64; it must be set as Int32",
        || fmu.set_int64(vr::LEVEL, 1),
    );
    refused(
        &fmu,
        "`gain` = 1: a Float64 tunable parameter cannot be set as Int32; it must be set as Float64",
        || fmu.set_int32(vr::GAIN, 1),
    );
    refused(&fmu, "`on` = true: a Boolean output cannot be set", || {
        fmu.set_boolean(vr::ON, 1)
    });
    refused(
        &fmu,
        "`file` = \"x\": invalid digit found in string; it must be a number",
        || fmu.set_string(vr::FILE, c"x"),
    );
    refused(&fmu, "values[0] = \"\\xff\" is not UTF-8", || {
        fmu.set_string(vr::FILE, c"\xff")
    });
    refused(
        &fmu,
        "`gain` = \"x\": a Float64 tunable parameter cannot be set as String",
        || fmu.set_string(vr::GAIN, c"x"),
    );
    refused(
        &fmu,
        "`law` is an Enumeration fixed parameter and cannot be read as Int32; it must be read as Int64",
        || fmu.get_int32(vr::LAW).0,
    );
    refused(
        &fmu,
        "`file` is a String fixed parameter and cannot be read as Boolean; it must be read as String",
        || fmu.get_boolean(vr::FILE).0,
    );
    refused(
        &fmu,
        "`y` is a Float64 output and cannot be read as String",
        || fmu.get_string(vr::Y).0,
    );
    // SAFETY: one reference and one place each.
    unsafe {
        let c = fmu.c;
        refused(
            &fmu,
            "`y` is a Float64 output and cannot be read as Float32; it must be read as Float64",
            || fmi3GetFloat32(c, &vr::Y, 1, &mut 0.0, 1),
        );
        refused(
            &fmu,
            "`held` = 1: a Float64 input cannot be set as Float32; it must be set as Float64",
            || fmi3SetFloat32(c, &vr::HELD, 1, &1.0, 1),
        );
        refused(&fmu, "unknown value reference 18", || {
            fmi3GetUInt8(c, &vr::COUNT, 1, &mut 0, 1)
        });
        let of_time = "value reference 65536 is `time`, the independent variable; it can only be read, as Float64";
        refused(&fmu, of_time, || fmi3GetInt32(c, &TIME, 1, &mut 0, 1));
        refused(&fmu, of_time, || fmu.get_boolean(TIME).0);
        refused(&fmu, of_time, || fmi3GetFloat32(c, &TIME, 1, &mut 0.0, 1));
        refused(&fmu, of_time, || {
            fmi3GetString(c, &TIME, 1, &mut ptr::null(), 1)
        });
        refused(&fmu, of_time, || fmi3SetFloat64(c, &TIME, 1, &1.0, 1));
        refused(&fmu, of_time, || {
            fmi3GetDirectionalDerivative(c, &vr::Y, 1, &TIME, 1, &1.0, 1, &mut 0.0, 1)
        });
        refused(
            &fmu,
            "`held` is a Float64 input; it must be a Clock, and this FMU has none",
            || fmi3SetIntervalDecimal(c, &vr::HELD, 1, &1.0),
        );
        refused(&fmu, "nValues = 2 must be 1", || {
            fmi3GetString(c, &vr::FILE, 1, [ptr::null(); 2].as_mut_ptr(), 2)
        });
    }
}

#[test]
fn null_arrays_and_places_are_refused() {
    let fmu = Fmu3::stepping(EVENTS);
    let (c, vr) = (fmu.c, &vr::HELD);
    // SAFETY: NULL is what is tested; everything else has one element.
    unsafe {
        refused(
            &fmu,
            "valueReferences = NULL with 1 elements; NULL must come with 0 elements",
            || fmi3SetFloat64(c, ptr::null(), 1, &1.0, 1),
        );
        refused(&fmu, "values = NULL with 1 elements", || {
            fmi3SetFloat64(c, vr, 1, ptr::null(), 1)
        });
        refused(&fmu, "values = NULL with 1 elements", || {
            fmi3GetFloat64(c, vr, 1, ptr::null_mut(), 1)
        });
        refused(&fmu, "elements is longer than memory", || {
            fmi3SetFloat64(c, vr, usize::MAX, &1.0, 1)
        });
        refused(&fmu, "categories = NULL with 2 elements", || {
            fmi3SetDebugLogging(c, 1, 2, ptr::null())
        });
        refused(
            &fmu,
            "FMUState = NULL must be a pointer for the result",
            || fmi3GetFMUState(c, ptr::null_mut()),
        );
        refused(
            &fmu,
            "lastSuccessfulTime = NULL must be a pointer for the result",
            || fmi3DoStep(c, 0.0, 1.0, 1, &mut 0, &mut 0, &mut 0, ptr::null_mut()),
        );
        refused(&fmu, "eventHandlingNeeded = NULL must be a pointer", || {
            fmi3DoStep(c, 0.0, 1.0, 1, ptr::null_mut(), &mut 0, &mut 0, &mut 0.0)
        });
        refused(&fmu, "nDependencies = NULL must be a pointer", || {
            fmi3GetNumberOfVariableDependencies(c, crate::probe::vr::Y, ptr::null_mut())
        });
        refused(&fmu, "nDependencies = 1 must be 2", || {
            fmi3GetVariableDependencies(c, crate::probe::vr::Y, &mut 0, &mut 0, &mut 0, &mut 0, 1)
        });
        assert_eq!(fmi3FreeFMUState(c, ptr::null_mut()), Status::Ok);
        let empty = fmi3SetFloat64(c, ptr::null(), 0, ptr::null(), 0);
        assert_eq!(empty, Status::Ok);
    }
}

#[test]
fn outputs_are_never_nan_and_times_without_sense_are_refused() {
    let fmu = Fmu3::initialized(EVENTS);
    assert_eq!(fmu.set_int32(vr::FAULT, 6), Status::Ok);
    refused(&fmu, "`y` became NaN; it must be finite", || {
        fmu.try_get::<1>(&[vr::Y]).0
    });
    assert_eq!(fmu.set_int32(vr::FAULT, 5), Status::Ok);
    refused(&fmu, "fmi3GetFloat64: no output for fault = 5", || {
        fmu.try_get::<2>(&[vr::X[0]]).0
    });
    let fmu = Fmu3::instantiated(PLAIN);
    refused(&fmu, "start time = NaN s must be finite", || {
        fmu.enter_initialization(f64::NAN, None)
    });
    refused(
        &fmu,
        "stop time = 1 s must be at least the start time = 2 s",
        || fmu.enter_initialization(2.0, Some(1.0)),
    );
}

#[test]
fn arguments_that_are_not_for_this_fmu_give_no_instance() {
    let why = |made: Result<Fmu3, Vec<Message>>| {
        let messages = made.err().expect("no instance");
        let [message] = &messages[..] else {
            panic!("{messages:?}")
        };
        assert_eq!(
            (message.status, message.category.as_str()),
            (Status::Error, "logStatusError")
        );
        message.text.clone()
    };
    let text = why(Fmu3::try_with(PLAIN, c"{1}", c"/tmp/"));
    assert!(
        text.starts_with("fmi3InstantiateCoSimulation: instantiationToken = {1} must be {"),
        "{text}"
    );
    const UNUSABLE: [(&[u32], &str); 3] = [
        (&[99], "unknown value reference 99"),
        (
            &[vr::U[0]],
            "`u[1]` must be a variable with intermediateUpdate = true",
        ),
        (
            &[vr::DOUBLED],
            "`doubled` must be a variable with intermediateUpdate = true",
        ),
    ];
    for (required, reason) in UNUSABLE {
        let text = why(Fmu3::try_with(
            Options { required, ..PLAIN },
            token(),
            c"/tmp/",
        ));
        assert!(text.contains(reason), "{text}");
    }
    // Silence where logging is off.
    let silent = Fmu3::try_with(Options { on: false, ..PLAIN }, c"{1}", c"/tmp/");
    assert_eq!(silent.err(), Some(Vec::new()));
    // SAFETY: no callbacks, valid strings.
    unsafe {
        assert!(
            fmi3InstantiateModelExchange(
                c"a".as_ptr(),
                token().as_ptr(),
                ptr::null(),
                0,
                1,
                ptr::null_mut(),
                None
            )
            .is_null()
        );
        assert!(
            fmi3InstantiateScheduledExecution(
                c"a".as_ptr(),
                token().as_ptr(),
                ptr::null(),
                0,
                1,
                ptr::null_mut(),
                None,
                None,
                None,
                None
            )
            .is_null()
        );
    }
}
