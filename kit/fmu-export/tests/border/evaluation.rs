//! What outputs and steps share is computed once.

use crate::client::*;
use crate::probe::{EVALUATIONS, vr};
use fmu_export::ffi::*;

/// How many evaluations `f` makes. (The model itself checks that each belongs to its state and
/// inputs.)
fn evaluations(f: impl FnOnce()) -> u32 {
    let before = EVALUATIONS.get();
    f();
    EVALUATIONS.get() - before
}

/// A communication step with staged exchange: get after set, twice, and outputs again after the
/// step.
#[test]
fn a_coupled_step_evaluates_once_per_state_and_inputs() {
    let fmu = Fmu::stepping();
    for k in 0..5 {
        let count = evaluations(|| {
            assert_eq!(fmu.set(&vr::U, &[f64::from(k), 2.0]), Status::Ok);
            fmu.get([vr::X[0], vr::Y]);
            assert_eq!(fmu.set_boolean(vr::SWITCH, (k + 1) % 2), Status::Ok);
            assert_eq!(fmu.get_boolean(vr::ON), (k + 1) % 2);
            assert_eq!(fmu.directional(&[vr::Y], &[vr::U[1]], &[1.0]).1, [1.0]);
            assert_eq!(fmu.step(f64::from(k), 1.0), Status::Ok);
        });
        assert_eq!(count, 1, "step {k}");
        // Of the new state; the set of the next round makes another.
        let after = evaluations(|| {
            fmu.get([vr::X[0], vr::Y]);
        });
        assert_eq!(after, 1);
    }
}

#[test]
fn only_what_it_reads_and_what_changes_makes_an_evaluation_anew() {
    let fmu = Fmu::stepping();
    let after = |change: &dyn Fn()| {
        fmu.get([vr::Y]);
        evaluations(|| {
            change();
            fmu.get([vr::Y]);
        })
    };
    let ok = |status: Status| assert_eq!(status, Status::Ok);
    assert_eq!(after(&|| ()), 0);
    assert_eq!(after(&|| ok(fmu.set(&[vr::U[0]], &[1.0]))), 1);
    assert_eq!(after(&|| ok(fmu.set(&[vr::U[0]], &[1.0]))), 0); // the same again
    assert_eq!(after(&|| ok(fmu.set(&[vr::U[0]], &[0.0]))), 1);
    assert_eq!(after(&|| ok(fmu.set(&[vr::U[0]], &[-0.0]))), 1); // 1/u would differ
    assert_eq!(after(&|| ok(fmu.set_boolean(vr::SWITCH, 1))), 0); // not read
    assert_eq!(after(&|| ok(fmu.set(&[vr::GAIN], &[2.0]))), 1); // tuned
    let state = fmu.save();
    assert_eq!(after(&|| ok(fmu.step(0.0, 0.5))), 1);
    assert_eq!(after(&|| ok(fmu.restore(state))), 1);
}

/// A step that is discarded leaves the state and what was computed of it.
#[test]
fn a_discarded_step_keeps_the_evaluation() {
    let fmu = Fmu::stepping();
    assert_eq!(fmu.set_integer(vr::FAULT, 2), Status::Ok);
    fmu.get([vr::Y]);
    let count = evaluations(|| {
        assert_eq!(fmu.step(0.0, 0.5), Status::Discard);
        fmu.get([vr::Y]);
    });
    assert_eq!(count, 0);
}

/// During initialization every set makes the model anew, whether its evaluation reads the input or
/// not.
#[test]
fn during_initialization_the_model_is_made_anew() {
    let fmu = Fmu::initializing();
    fmu.get([vr::Y]);
    assert_eq!(fmu.set_boolean(vr::SWITCH, 1), Status::Ok);
    assert_eq!(fmu.get([vr::Y]), [0.0]);
    assert_eq!(fmu.get_boolean(vr::ON), 1);
    fmu.start();
}
