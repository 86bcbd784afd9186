//! Messages: as they are, only where logging is on, and never with a worse status than the function
//! returns.

use crate::client3::*;
use crate::probe::vr;
use std::ffi::CString;

fn switch(fmu: &Fmu3, on: bool, names: &[&str]) -> Status {
    let names: Vec<_> = names
        .iter()
        .map(|name| CString::new(*name).unwrap())
        .collect();
    let pointers: Vec<_> = names.iter().map(|name| name.as_ptr()).collect();
    // SAFETY: a live instance, valid strings.
    unsafe { fmi3SetDebugLogging(fmu.c, on.into(), pointers.len(), pointers.as_ptr()) }
}

/// One refused call and one discarded one, a warning and an event.
fn provoke(fmu: &Fmu3) -> Vec<(Status, String)> {
    let before = fmu.messages().len();
    assert_eq!(fmu.set(&[vr::COUNT], &[0.0]), Status::Error);
    assert_eq!(fmu.set(&[vr::HELD], &[f64::NAN]), Status::Discard);
    assert_eq!(fmu.set_int32(vr::FAULT, 3), Status::Ok);
    let state = fmu.save();
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Ok);
    assert_eq!(fmu.restore(state), Status::Ok);
    let messages = fmu.messages().into_iter().skip(before);
    messages.map(|m| (m.status, m.category)).collect()
}

const ERROR: (Status, &str) = (Status::Error, "logStatusError");
const DISCARD: (Status, &str) = (Status::Discard, "logStatusDiscard");
/// The step that warned returned fmi3OK, and no message may have a worse status (section 2.3.1).
const WARNING: (Status, &str) = (Status::Ok, "logStatusWarning");
const EVENT: (Status, &str) = (Status::Ok, "logEvents");

fn expect(fmu: &Fmu3, expected: &[(Status, &str)]) {
    let expected: Vec<_> = expected
        .iter()
        .map(|(s, c)| (*s, (*c).to_owned()))
        .collect();
    assert_eq!(provoke(fmu), expected);
}

#[test]
fn categories_are_switched_on_and_off_one_by_one() {
    let fmu = Fmu3::stepping(PLAIN);
    expect(&fmu, &[ERROR, DISCARD, WARNING, EVENT]);
    assert_eq!(
        switch(&fmu, false, &["logStatusError", "logEvents"]),
        Status::Ok
    );
    expect(&fmu, &[DISCARD, WARNING]);
    // On means these too, not only these: FMI 2.0 has it the other way.
    assert_eq!(switch(&fmu, true, &["logEvents"]), Status::Ok);
    expect(&fmu, &[DISCARD, WARNING, EVENT]);
    assert_eq!(switch(&fmu, false, &[]), Status::Ok);
    expect(&fmu, &[]);
    assert_eq!(switch(&fmu, true, &["logAll"]), Status::Ok);
    expect(&fmu, &[ERROR, DISCARD, WARNING, EVENT]);
    assert_eq!(switch(&fmu, true, &["logWeather"]), Status::Error);
    assert_eq!(
        fmu.last().text,
        "fmi3SetDebugLogging: category `logWeather` must be one of logAll, logEvents, logStatusWarning, logStatusDiscard, logStatusError"
    );
}

/// Without loggingOn nothing is said, not even of errors: FMI 2.0 has it the other way.
#[test]
fn an_instance_without_logging_is_silent_until_it_is_switched_on() {
    let fmu = Fmu3::stepping(Options { on: false, ..PLAIN });
    expect(&fmu, &[]);
    assert_eq!(switch(&fmu, true, &["logStatusError"]), Status::Ok);
    expect(&fmu, &[ERROR]);
}

/// `%` and `#` mean nothing: the message is no format.
#[test]
fn texts_are_as_they_are() {
    let fmu = Fmu3::initializing(PLAIN);
    assert_eq!(fmu.set_string(vr::FILE, c"100 % #1"), Status::Error);
    assert_eq!(
        fmu.last().text,
        "fmi3SetString: `file` = \"100 % #1\": invalid digit found in string; it must be a number"
    );
}
