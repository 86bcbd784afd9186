//! Values through the life of an instance.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;
use std::ffi::{CStr, CString};
use std::ptr;
use std::sync::Mutex;

#[test]
fn version_and_platform_are_those_of_the_standard() {
    // SAFETY: static C strings.
    let texts = unsafe { [fmi2GetVersion(), fmi2GetTypesPlatform()].map(|s| CStr::from_ptr(s)) };
    assert_eq!(texts, [c"2.0", c"default"]);
}

/// Oracle: x_dot is constant, so x = x0 + t (u + rate), exact in binary for these numbers.
#[test]
fn a_run_gives_the_closed_form() {
    let fmu = Fmu::initializing();
    assert_eq!(
        fmu.set(&[vr::RATE[0], vr::U[0], vr::GAIN], &[0.5, 1.25, 2.0]),
        Status::Ok
    );
    assert_eq!(fmu.get(vr::X), [0.0, 0.25]);
    fmu.start();
    for k in 0..8 {
        assert_eq!(fmu.step(f64::from(k) * 0.125, 0.125), Status::Ok);
    }
    assert_eq!(
        fmu.get([vr::X[0], vr::X[1], vr::Y, vr::INNER]),
        [1.75, 0.5, 3.5, 2.25]
    );
    assert_eq!(fmu.last_time(), 1.0);
    // An output of a current input follows a set without a step.
    assert_eq!(fmu.set(&[vr::U[1]], &[4.0]), Status::Ok);
    assert_eq!(
        fmu.get([vr::Y, vr::U[1], vr::HELD, vr::RATE[0]]),
        [7.5, 4.0, 1.5, 0.5]
    );
    assert_eq!(fmu.call(fmi2Terminate), Status::Ok);
    assert_eq!(fmu.get([vr::Y]), [7.5]);
    let text: Vec<_> = fmu.messages().into_iter().map(|m| m.text).collect();
    assert_eq!(text, ["initialized", "terminated"]);
}

#[test]
fn all_types_pass_through() {
    let fmu = Fmu::initializing();
    assert_eq!(fmu.set_integer(vr::LAW, 2), Status::Ok);
    assert_eq!(fmu.set_integer(vr::LEVEL, -3), Status::Ok);
    assert_eq!(fmu.set_boolean(vr::ENABLED, 0), Status::Ok);
    fmu.start();
    assert_eq!(fmu.set_integer(vr::FAULT, 21), Status::Ok);
    assert_eq!(fmu.set_boolean(vr::SWITCH, 1), Status::Ok);
    assert_eq!(
        [vr::LAW, vr::LEVEL, vr::FAULT, vr::DOUBLED].map(|v| fmu.get_integer(v)),
        [2, -3, 21, 42]
    );
    assert_eq!(
        [vr::ENABLED, vr::SWITCH, vr::ON].map(|v| fmu.get_boolean(v)),
        [0, 1, 1]
    );
    assert_eq!(fmu.get_string(vr::FILE), "4");
}

/// The file sets everything, the numbers set explicitly win, in whichever order they come.
#[test]
fn order_of_setting_parameters_does_not_matter() {
    for file_first in [true, false] {
        let fmu = Fmu::initializing();
        let file = || assert_eq!(fmu.set_string(vr::FILE, c"-2"), Status::Ok);
        let number = || assert_eq!(fmu.set(&[vr::RATE[1]], &[1.5]), Status::Ok);
        if file_first {
            file();
            number();
        } else {
            number();
            file();
        }
        assert_eq!(
            fmu.get([vr::GAIN, vr::RATE[0], vr::RATE[1]]),
            [0.5, 7.5, 1.5]
        );
        assert_eq!(
            (fmu.get_integer(vr::LEVEL), fmu.get_string(vr::FILE)),
            (-2, "-2".to_owned())
        );
        // `/tmp/a b` came through fmuResourceLocation.
        assert_eq!(fmu.get_integer(vr::LAW), 2);
    }
}

#[test]
fn reset_goes_back_to_as_instantiated() {
    let fresh = Fmu::instantiated();
    let fmu = Fmu::initializing();
    assert_eq!(fmu.set(&[vr::RATE[0], vr::U[0]], &[0.5, 1.25]), Status::Ok);
    fmu.start();
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    assert_eq!(fmu.call(fmi2Reset), Status::Ok);
    assert_eq!(fmu.snapshot(), fresh.snapshot());
}

#[test]
fn a_tunable_parameter_acts_at_once() {
    let fmu = Fmu::stepping();
    assert_eq!(fmu.set(&[vr::U[0]], &[1.0]), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0), Status::Ok);
    assert_eq!(fmu.get([vr::Y]), [3.0]);
    assert_eq!(fmu.set(&[vr::GAIN], &[5.0]), Status::Ok);
    assert_eq!(fmu.get([vr::Y]), [5.0]);
}

#[test]
fn empty_batches_may_come_with_null() {
    let fmu = Fmu::stepping();
    let (c, null) = (fmu.c, ptr::null::<u32>());
    // SAFETY: NULL with no elements.
    let statuses = unsafe {
        [
            fmi2SetReal(c, null, 0, ptr::null()),
            fmi2SetInteger(c, null, 0, ptr::null()),
            fmi2SetBoolean(c, null, 0, ptr::null()),
            fmi2SetString(c, null, 0, ptr::null()),
            fmi2GetReal(c, null, 0, ptr::null_mut()),
            fmi2GetInteger(c, null, 0, ptr::null_mut()),
            fmi2GetBoolean(c, null, 0, ptr::null_mut()),
            fmi2GetString(c, null, 0, ptr::null_mut()),
            fmi2SetRealInputDerivatives(c, null, 0, ptr::null(), ptr::null()),
            fmi2GetRealOutputDerivatives(c, null, 0, ptr::null(), ptr::null_mut()),
            fmi2GetDirectionalDerivative(c, null, 0, null, 0, ptr::null(), ptr::null_mut()),
            fmi2SetDebugLogging(c, 1, 0, ptr::null()),
        ]
    };
    assert_eq!(statuses, [Status::Ok; 12]);
}

/// Arguments of fmi2Instantiate that are refused, with the message.
#[test]
fn wrong_instantiations_give_null_and_say_why() {
    let good = guid();
    let bare = CString::new(
        good.to_str()
            .unwrap()
            .trim_matches(['{', '}'])
            .to_uppercase(),
    )
    .unwrap();
    let cases: [(Str, i32, Str, Option<&str>); 8] = [
        (c"a".as_ptr(), 1, good.as_ptr(), None),
        (c"a".as_ptr(), 1, bare.as_ptr(), None),
        (
            ptr::null(),
            1,
            good.as_ptr(),
            Some("instanceName = NULL must be a name"),
        ),
        (
            c"".as_ptr(),
            1,
            good.as_ptr(),
            Some("instanceName is empty; it must be a name"),
        ),
        (
            c"a".as_ptr(),
            0,
            good.as_ptr(),
            Some("fmuType = 0 must be 1 (fmi2CoSimulation)"),
        ),
        (
            c"a".as_ptr(),
            77,
            good.as_ptr(),
            Some("fmuType = 77 must be 1 (fmi2CoSimulation)"),
        ),
        (
            c"a".as_ptr(),
            1,
            c"{other}".as_ptr(),
            Some("fmuGUID = {other} must be {"),
        ),
        (
            c"a".as_ptr(),
            1,
            ptr::null(),
            Some("fmuGUID = NULL must be {"),
        ),
    ];
    for (name, kind, guid, reason) in cases {
        let log = Mutex::new(Vec::new());
        let functions = callbacks(&log);
        // SAFETY: strings or NULL, valid callbacks.
        let c = unsafe { fmi2Instantiate(name, kind, guid, ptr::null(), &functions, 0, 0) };
        assert_eq!(c.is_null(), reason.is_some());
        let messages = log.lock().unwrap();
        match reason {
            Some(reason) => assert!(messages[0].text.contains(reason), "{messages:?}"),
            None => assert!(messages.is_empty(), "{messages:?}"),
        }
        // SAFETY: NULL or a live instance.
        unsafe { fmi2FreeInstance(c) };
    }
    // SAFETY: NULL callbacks cannot be called.
    let c = unsafe {
        fmi2Instantiate(
            c"a".as_ptr(),
            1,
            good.as_ptr(),
            ptr::null(),
            ptr::null(),
            0,
            0,
        )
    };
    assert!(c.is_null());
}

#[test]
fn an_unusable_resource_location_is_a_warning() {
    let fmu = Fmu::with(callbacks, c"http://elsewhere/x", false);
    let message = fmu.last();
    assert_eq!(
        (message.status, message.category.as_str()),
        (Status::Warning, "logStatusWarning")
    );
    assert!(message.text.contains("`http://elsewhere/x`"), "{message:?}");
}

#[test]
fn a_logger_of_null_is_not_called() {
    let silent = |_: &Mutex<Vec<Message>>| CallbackFunctions {
        logger: None,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: ptr::null_mut(),
    };
    let fmu = Fmu::with(silent, c"", true);
    assert_eq!(fmu.step(0.0, 1.0), Status::Error);
}

#[test]
fn logging_can_be_chosen() {
    let fmu = Fmu::with(callbacks, c"file:///", false);
    let wrong = || assert_eq!(fmu.step(0.0, 1.0), Status::Error);
    let count = |expected: usize| {
        assert_eq!(
            std::mem::take(&mut *fmu.log.lock().unwrap()).len(),
            expected
        )
    };
    let debug = |on: i32, categories: &[&CStr]| {
        let pointers: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        // SAFETY: live instance, valid strings.
        unsafe { fmi2SetDebugLogging(fmu.c, on, pointers.len(), pointers.as_ptr()) }
    };
    let too_large = || assert_eq!(fmu.set(&[vr::GAIN], &[11.0]), Status::Discard);
    let reset = || assert_eq!(fmu.call(fmi2Reset), Status::Ok);
    let all = |expected: [usize; 3]| {
        for (call, expected) in [&wrong as &dyn Fn(), &too_large, &reset]
            .iter()
            .zip(expected)
        {
            call();
            count(expected);
        }
    };
    all([1, 0, 0]); // loggingOn = false leaves errors
    for (on, categories, expected) in [
        (1, &[] as &[_], [1, 1, 1]),
        (0, &[], [1, 0, 0]),
        (1, &[c"logEvents", c"logStatusWarning"], [1, 0, 1]),
        (0, &[c"logEvents"], [1, 0, 0]),
        (1, &[c"logAll"], [1, 1, 1]),
        (0, &[c"logStatusError"], [1, 1, 1]), // errors are never switched off
        (0, &[c"logStatusDiscard"], [1, 0, 1]),
        // Of the standard, but not declared; and of nobody.
        (1, &[c"logNonlinearSystems"], [1, 0, 0]),
        (1, &[c"logEverything", c"logStatusDiscard"], [1, 1, 0]),
    ] {
        assert_eq!(debug(on, categories), Status::Ok);
        all(expected);
    }
}

/// A message is a format without arguments: `%` would ask for some, `#` would begin a value
/// reference (FMI 2.0.4, section 2.1.5).
#[test]
fn messages_are_sent_as_text() {
    let fmu = Fmu::initializing();
    assert_eq!(fmu.set_string(vr::FILE, c"100 % #1"), Status::Error);
    let message = fmu.last();
    assert_eq!(message.name, "probe 1");
    assert!(
        message
            .format
            .contains("`file` = \"100 %% ##1\": invalid digit"),
        "{message:?}"
    );
}

/// Each thread has its own instance with its own input; none sees another's.
#[test]
fn instances_in_threads_are_independent() {
    const STEPS: i32 = if cfg!(miri) { 20 } else { 2000 };
    std::thread::scope(|scope| {
        for thread in 0..4 {
            scope.spawn(move || {
                let fmu = Fmu::stepping();
                for k in 0..STEPS {
                    assert_eq!(fmu.set(&[vr::U[0]], &[f64::from(thread)]), Status::Ok);
                    assert_eq!(fmu.step(f64::from(k) * 0.5, 0.5), Status::Ok);
                }
                assert_eq!(fmu.get([vr::X[0]]), [0.5 * f64::from(STEPS * thread)]);
            });
        }
    });
}
