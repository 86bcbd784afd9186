//! Saved states: exact, of this version of FMI only, with the mode they were saved in.

use crate::client::Fmu;
use crate::client3::*;
use crate::probe::vr;
use crate::saved::STRIDE;
use fmu_export::ffi as client;
use std::ptr;

#[test]
fn a_restored_state_goes_on_bit_for_bit() {
    let fmu = Fmu3::stepping(PLAIN);
    let run = |fmu: &Fmu3, t: f64| {
        assert_eq!(fmu.set(&[vr::U[0]], &[0.1, 0.3]), Status::Ok);
        assert_eq!(fmu.step(t, 0.7).0, Status::Ok);
        fmu.get::<3>(&[vr::X[0], vr::Y]).map(f64::to_bits)
    };
    run(&fmu, 0.0);
    let state = fmu.save();
    let first = run(&fmu, 0.7);
    assert_eq!(fmu.restore(state), Status::Ok);
    assert_eq!(run(&fmu, 0.7), first);
    // In another instance, straight after instantiation.
    let other = Fmu3::instantiated(PLAIN);
    let (status, copy) = other.deserialize(&fmu.serialize(state));
    assert_eq!(status, Status::Ok);
    assert_eq!(other.restore(copy), Status::Ok);
    assert_eq!(run(&other, 0.7), first);
    assert_eq!(fmu.restore(copy), Status::Error);
}

/// A state that was saved in Event Mode leads back there.
#[test]
fn the_mode_is_part_of_the_state() {
    let fmu = Fmu3::initialized(EVENTS);
    let in_event_mode = fmu.save();
    assert_eq!(fmu.call(fmi3EnterStepMode), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Ok);
    assert_eq!(fmu.restore(in_event_mode), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Error);
    assert_eq!(fmu.call(fmi3EnterStepMode), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Ok);
}

#[test]
fn bytes_of_the_other_version_are_refused() {
    let (two, three) = (Fmu::stepping(), Fmu3::stepping(PLAIN));
    let (of_two, of_three) = (two.serialize(two.save()), three.serialize(three.save()));
    assert_eq!(three.deserialize(&of_two), (Status::Error, ptr::null_mut()));
    assert_eq!(
        three.last().text,
        "fmi3DeserializeFMUState: serialized state is of an instance of FMI 2.0; it must be of FMI 3.0"
    );
    assert_eq!(
        two.deserialize(&of_three),
        (client::Status::Error, ptr::null_mut())
    );
    assert!(
        two.last()
            .text
            .contains("is of an instance of FMI 3.0; it must be of FMI 2.0")
    );
}

#[test]
fn foreign_and_damaged_bytes_are_refused() {
    let fmu = Fmu3::stepping(PLAIN);
    let bytes = fmu.serialize(fmu.save());
    for n in (0..bytes.len()).step_by(STRIDE) {
        assert_eq!(fmu.deserialize(&bytes[..n]).0, Status::Error);
        let mut damaged = bytes.clone();
        damaged[n] ^= 1;
        assert_eq!(fmu.deserialize(&damaged).0, Status::Error, "byte {n}");
    }
    let mut state = fmu.save();
    let copy = state;
    assert_eq!(fmu.free(&mut state), Status::Ok);
    assert!(state.is_null());
    assert_eq!(fmu.restore(copy), Status::Error);
    assert_eq!(fmu.free(&mut { copy }), Status::Error);
    // SAFETY: a live instance, less room than is needed.
    let short = unsafe { fmi3SerializeFMUState(fmu.c, fmu.save(), [0; 4].as_mut_ptr(), 4) };
    assert_eq!(short, Status::Error);
    assert!(fmu.last().text.contains("size = 4 must be at least"));
}
