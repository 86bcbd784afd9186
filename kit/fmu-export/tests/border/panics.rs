//! A panic of the model poisons its instance, and only that.

use crate::client::*;
use crate::client3::{Fmu3, PLAIN, token};
use crate::probe::{PANICS_WHEN_MADE, vr};
use fmu_export::ffi::*;
use std::process::Command;
use std::ptr;
use std::sync::Mutex;

/// An instance in which the model has panicked, once in a step and once in an output, with a state
/// from before.
fn lost(fault: i32) -> (Fmu, FmuState) {
    let fmu = Fmu::stepping();
    let before = fmu.save();
    assert_eq!(fmu.set_integer(vr::FAULT, fault), Status::Ok);
    let status = if fault == 1 {
        fmu.step(0.0, 1.0)
    } else {
        fmu.try_get(vr::Y)
    };
    assert_eq!(status, Status::Error);
    (fmu, before)
}

/// fmi2Fatal would mean that all instances are corrupt; after fmi2Error a restored state or a reset
/// leads on (FMI 2.0.4, section 2.1.3).
#[test]
fn a_panic_is_an_error_of_its_instance_only() {
    for (fault, what) in [(1, "asked to in step"), (4, "asked to in output by 4")] {
        let other = Fmu::stepping();
        let (fmu, _) = lost(fault);
        let message = fmu.last();
        assert_eq!(
            (message.status, message.category.as_str()),
            (Status::Error, "logStatusError")
        );
        for part in [
            what,
            "panic: ",
            "probe.rs:",
            "the instance needs fmi2Reset or fmi2SetFMUstate",
        ] {
            assert!(message.text.contains(part), "{message:?}");
        }
        // What it computed meanwhile cannot be trusted.
        assert_eq!(fmu.step(0.0, 1.0), Status::Error);
        assert_eq!(fmu.set(&[vr::U[0]], &[1.0]), Status::Error);
        assert_eq!(fmu.try_get(vr::X[0]), Status::Error);
        // SAFETY: a live instance, a place.
        assert_eq!(
            unsafe { fmi2GetFMUstate(fmu.c, &mut ptr::null_mut()) },
            Status::Error
        );
        assert!(fmu.last().text.contains("lost by a panic"));
        assert_eq!(fmu.call(fmi2Terminate), Status::Ok);
        // The other one goes on.
        assert_eq!(other.step(0.0, 1.0), Status::Ok);
    } // and all are freed
}

#[test]
fn a_restored_state_or_a_reset_leads_on_after_a_panic() {
    for fault in [1, 4] {
        let (fmu, before) = lost(fault);
        assert_eq!(fmu.restore(before), Status::Ok);
        assert_eq!(fmu.step(0.0, 1.0), Status::Ok);
        assert_eq!(fmu.get(vr::X), [0.0, 0.5]);
        let (fmu, _) = lost(fault);
        assert_eq!(fmu.call(fmi2Reset), Status::Ok);
        assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
        fmu.start();
        assert_eq!(fmu.step(0.0, 1.0), Status::Ok);
        assert_eq!(fmu.get(vr::X), [0.0, 0.5]);
    }
}

/// What the model does when an instance is made is caught, too: there is none, and the logger hears
/// why. Others can be made afterwards.
#[test]
fn a_panic_when_an_instance_is_made_gives_null() {
    let (log, guid, token) = (Mutex::new(Vec::new()), guid(), token());
    let functions = callbacks(&log);
    PANICS_WHEN_MADE.set(true);
    // SAFETY: valid strings and callbacks.
    let c = unsafe {
        fmi2Instantiate(
            c"a".as_ptr(),
            1,
            guid.as_ptr(),
            ptr::null(),
            &functions,
            0,
            1,
        )
    };
    let of_3 = Fmu3::try_with(PLAIN, token, c"/tmp").map(drop);
    PANICS_WHEN_MADE.set(false);
    assert!(c.is_null());
    let text = log.lock().unwrap()[0].text.clone();
    let start = "fmi2Instantiate: panic: asked to when made (";
    assert!(text.starts_with(start), "{text}");
    let text = of_3.expect_err("no instance")[0].text.clone();
    let start = "fmi3InstantiateCoSimulation: panic: asked to when made (";
    assert!(text.starts_with(start), "{text}");
    assert_eq!(Fmu::stepping().step(0.0, 1.0), Status::Ok);
}

/// Runs the first test above in a process of its own and looks at what it prints beside the
/// harness.
#[test]
#[cfg_attr(miri, ignore = "Miri starts no processes")]
fn a_panic_prints_nothing() {
    let test = "panics::a_panic_is_an_error_of_its_instance_only";
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture", "--test-threads=1"])
        .output()
        .unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(!String::from_utf8_lossy(&output.stdout).contains("asked to"));
}
