//! Intermediate updates: one at the end of each step, for importers that name variables to read.

use crate::client3::*;
use crate::probe::vr;
use std::ptr;

const UPDATES: Options = Options {
    required: &[vr::X[0], vr::Y],
    look: Some(look),
    ..PLAIN
};

/// What is allowed within a step is done, what is not is refused.
fn look(fmu: &Fmu3) {
    let [x, _, y]: [f64; 3] = fmu.get(&[vr::X[0], vr::Y]);
    assert_eq!(y, 3.0 * x);
    assert_eq!(fmu.output_derivatives(&[vr::Y], &[1], 1).0, Status::Ok);
    assert_eq!(fmu.try_get::<1>(&[vr::INNER]).0, Status::Error);
    assert_eq!(fmu.set(&[vr::U[0]], &[1.0, 1.0]), Status::Error);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Error);
    assert_eq!(fmu.call(fmi3EnterEventMode), Status::Error);
    assert_eq!(fmu.call(fmi3Terminate), Status::Error);
    assert_eq!(fmu.call(fmi3Reset), Status::Error);
    assert_eq!(fmu.dependencies(vr::Y).0, Status::Error);
    // SAFETY: a live instance; freeing it here is ignored.
    unsafe {
        assert_eq!(fmi3GetFMUState(fmu.c, &mut ptr::null_mut()), Status::Error);
        assert_eq!(fmi3SetDebugLogging(fmu.c, 1, 0, ptr::null()), Status::Error);
        fmi3FreeInstance(fmu.c);
    }
}

#[test]
fn the_end_of_a_step_is_shown() {
    let fmu = Fmu3::stepping(UPDATES);
    assert_eq!(fmu.set(&[vr::U[0]], &[2.0, 0.0]), Status::Ok);
    assert_eq!(fmu.step(0.0, 0.5).0, Status::Ok);
    assert_eq!(fmu.step(0.5, 0.25).0, Status::Ok);
    // No set is asked for, a get is allowed, the step is finished, and nothing returns early.
    assert_eq!(fmu.seen(), [(0.5, [0, 1, 1, 0]), (0.75, [0, 1, 1, 0])]);
    assert_eq!(fmu.get(&[vr::X[0]]), [1.5, 0.4375]);
    let refused = fmu.messages().into_iter().map(|m| m.text);
    assert_eq!(
        refused
            .filter(|text| text.contains("must be one of requiredIntermediateVariables"))
            .count(),
        2
    );
}

#[test]
fn a_failed_step_shows_nothing() {
    let fmu = Fmu3::stepping(UPDATES);
    assert_eq!(fmu.set_int32(vr::FAULT, 2), Status::Ok);
    assert_eq!(fmu.step(0.0, 0.5).0, Status::Discard);
    assert_eq!(fmu.seen(), []);
    let none = Fmu3::stepping(Options {
        required: &[],
        ..UPDATES
    });
    assert_eq!(none.step(0.0, 0.5).0, Status::Ok);
    assert_eq!(none.seen(), []);
}
