//! A panic of the model poisons its instance, and only that.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;
use std::process::Command;
use std::ptr;

#[test]
fn a_panic_is_fatal_for_its_instance_only() {
    for (fault, what) in [(1, "asked to in step"), (4, "asked to in output")] {
        let (fmu, other) = (Fmu::stepping(), Fmu::stepping());
        let before = fmu.save();
        assert_eq!(fmu.set_integer(vr::FAULT, fault), Status::Ok);
        let status = if fault == 1 {
            fmu.step(0.0, 1.0)
        } else {
            fmu.try_get(vr::Y)
        };
        assert_eq!(status, Status::Fatal);
        let message = fmu.last();
        assert_eq!(
            (message.status, message.category.as_str()),
            (Status::Fatal, "logStatusFatal")
        );
        for part in [
            what,
            "panic: ",
            "probe.rs:",
            "this instance can only be freed",
        ] {
            assert!(message.text.contains(part), "{message:?}");
        }
        // Nothing brings it back, not even a state from before.
        assert_eq!(fmu.step(0.0, 1.0), Status::Fatal);
        assert_eq!(fmu.set(&[vr::U[0]], &[1.0]), Status::Fatal);
        assert_eq!(fmu.try_get(vr::X[0]), Status::Fatal);
        assert_eq!(fmu.restore(before), Status::Fatal);
        assert_eq!(fmu.call(fmi2Reset), Status::Fatal);
        // SAFETY: a live instance, a place.
        assert_eq!(
            unsafe { fmi2GetFMUstate(fmu.c, &mut ptr::null_mut()) },
            Status::Fatal
        );
        assert_eq!(fmu.call(fmi2Terminate), Status::Ok);
        // The other one goes on.
        assert_eq!(other.step(0.0, 1.0), Status::Ok);
    } // and both are freed
}

/// Runs the test above in a process of its own and looks at what it prints beside the harness.
#[test]
fn a_panic_prints_nothing() {
    let test = "panics::a_panic_is_fatal_for_its_instance_only";
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture", "--test-threads=1"])
        .output()
        .unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(!String::from_utf8_lossy(&output.stdout).contains("asked to"));
}
