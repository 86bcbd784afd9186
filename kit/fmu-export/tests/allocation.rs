//! Set, step and get do not allocate, seen by an allocator that counts.
#![allow(missing_docs)]

#[path = "border/client.rs"]
#[allow(dead_code, clippy::undocumented_unsafe_blocks)]
// an importer for several tests, see border/main.rs
mod client;
#[path = "border/client3/mod.rs"]
#[allow(dead_code, clippy::undocumented_unsafe_blocks)] // see above
mod client3;
#[path = "border/probe.rs"]
#[allow(dead_code)] // see above
mod probe;
#[path = "border/states.rs"]
mod states;

use allocation_counter::measure;
use client::*;
use fmu_export::ffi::*;
use probe::vr;

#[test]
fn the_hot_path_does_not_allocate() {
    let fmu = Fmu::stepping();
    let hot = || {
        for k in 0..1000 {
            assert_eq!(
                fmu.set(&[vr::U[0], vr::U[1]], &[1.0, f64::from(k)]),
                Status::Ok
            );
            assert_eq!(fmu.derivatives(&[vr::U[0]], &[1], &[2.0]), Status::Ok);
            assert_eq!(fmu.set_boolean(vr::SWITCH, k % 2), Status::Ok);
            assert_eq!(fmu.step(f64::from(k) * 0.5, 0.5), Status::Ok);
            fmu.get([vr::X[0], vr::X[1], vr::Y]);
            assert_eq!(fmu.get_boolean(vr::ON), k % 2);
            assert_eq!(fmu.output_derivative(vr::Y, 1).0, Status::Ok);
        }
    };
    assert_eq!(measure(hot).count_total, 0);
    assert_ne!(
        measure(|| assert!(!fmu.save().is_null())).count_total,
        0,
        "the counter does not count"
    );
}

/// The same through the border of FMI 3.0, where values are exchanged in Event Mode.
#[test]
fn the_hot_path_of_fmi_3_does_not_allocate() {
    use client3::{EVENTS, Fmu3, Status as Status3, fmi3EnterEventMode, fmi3EnterStepMode};
    let fmu = Fmu3::stepping(EVENTS);
    let hot = || {
        for k in 0..1000 {
            let u = [1.0, f64::from(k)];
            assert_eq!(fmu.call(fmi3EnterEventMode), Status3::Ok);
            assert_eq!(fmu.set(&[vr::U[0]], &u), Status3::Ok);
            fmu.get::<3>(&[vr::X[0], vr::Y]);
            assert_eq!(fmu.update().0, Status3::Ok);
            assert_eq!(fmu.call(fmi3EnterStepMode), Status3::Ok);
            assert_eq!(fmu.set_boolean(vr::SWITCH, 1), Status3::Ok);
            assert_eq!(fmu.set_int32(vr::FAULT, 0), Status3::Ok);
            assert_eq!(fmu.step(f64::from(k) * 0.5, 0.5).0, Status3::Ok);
            fmu.get::<4>(&[vr::X[0], vr::Y, vr::INNER]);
            assert_eq!(fmu.get_boolean(vr::ON).1, 1);
        }
    };
    assert_eq!(measure(hot).count_total, 0);
    assert_ne!(measure(|| assert!(!fmu.save().is_null())).count_total, 0);
}
