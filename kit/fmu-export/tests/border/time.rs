//! Communication points, and steps that are discarded.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;

fn refused(fmu: &Fmu, t: f64, h: f64, text: &str) {
    let before = fmu.snapshot();
    assert_eq!(fmu.step(t, h), Status::Error, "{text}");
    let message = fmu.last().text;
    assert!(message.contains(text), "`{message}` lacks `{text}`");
    assert_eq!(fmu.snapshot(), before);
}

#[test]
fn steps_without_sense_are_refused() {
    let fmu = Fmu::stepping();
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    for (h, text) in [
        (0.0, "step size = 0 s must be finite and > 0"),
        (-0.5, "step size = -0.5 s"),
        (f64::NAN, "step size = NaN s"),
        (f64::INFINITY, "step size = inf s"),
        (1e-300, "does not move the time 0.5 s"),
    ] {
        refused(&fmu, 0.5, h, text);
    }
    for (t, shown) in [
        (0.0, "0"),
        (0.6, "0.6"),
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (-0.5, "-0.5"),
    ] {
        refused(
            &fmu,
            t,
            0.5,
            &format!("time = {shown} s must be the present time 0.5 s"),
        );
    }
    // "The same time" is relative to the step, and never less than a nanosecond.
    refused(&fmu, 0.5 + 2e-7, 1e-4, "fmi2DoStep: time =");
    refused(&fmu, 0.5 + 1.5e-9, 1e-7, "fmi2DoStep: time =");
    assert_eq!(fmu.step(0.5 + 0.9e-3, 1.0), Status::Ok);
    // Where the time is large, 10⁻⁹ of it.
    let late = Fmu::instantiated();
    late.setup(1000.0, None);
    assert_eq!(late.call(fmi2EnterInitializationMode), Status::Ok);
    late.start();
    refused(&late, 1000.0 + 1.1e-6, 1e-4, "fmi2DoStep: time =");
    assert_eq!(late.step(1000.0 + 0.9e-6, 1e-4), Status::Ok);
}

/// A clock t_0 + k h differs from the end of the step before by its rounding; the model is stepped
/// by h all the same, to the bit.
#[test]
fn the_rounding_of_a_clock_does_not_reach_the_model() {
    for start in [0.0, 1000.0] {
        let fmu = Fmu::instantiated();
        fmu.setup(start, None);
        assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
        fmu.start();
        assert_eq!(fmu.set(&[vr::U[1]], &[0.75]), Status::Ok); // x_dot = 0.75 + rate = 1
        let (mut x, mut has_differed) = (0.25, false);
        for k in 0..100 {
            let t = start + f64::from(k) * 0.1;
            has_differed |= k > 0 && t != fmu.last_time();
            assert_eq!(fmu.step(t, 0.1), Status::Ok);
            x += 0.1;
            assert_eq!(fmu.get([vr::X[1]]), [x], "{k}");
        }
        assert!(has_differed);
    }
}

/// A clock that is ahead of ours, within what rounding explains, does not make a step of one that
/// does not move it.
#[test]
fn a_step_that_does_not_move_the_importers_time_is_refused() {
    let fmu = Fmu::instantiated();
    fmu.setup(1e9, None);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    fmu.start();
    let ahead = 1e9 + 1e-3;
    refused(&fmu, ahead, 5e-324, "does not move the time");
    assert_eq!(fmu.step(ahead, 1e-3), Status::Ok);
}

/// Where the importer's time is not quite ours, the step makes up for it: the model is integrated
/// without a gap.
#[test]
fn a_step_ends_where_the_importer_says() {
    let fmu = Fmu::stepping();
    assert_eq!(fmu.set(&[vr::U[0]], &[1.0]), Status::Ok);
    let mut t = 0.0;
    for late in [0.0, 0.5e-3, -0.25e-3, 0.75e-3] {
        assert_eq!(fmu.step(t + late, 1.0), Status::Ok);
        t += late + 1.0;
        assert_eq!(fmu.last_time(), t);
        assert_eq!(fmu.get([vr::X[0]]), [t]); // the integral of 1
    }
}

/// The standard's own loop, `t += h`, and a clock that counts nanoseconds, at the steps where they
/// were refused.
#[test]
#[cfg_attr(miri, ignore = "too long for an interpreter")]
fn usual_clocks_are_accepted() {
    for (h, end) in [(1e-4, 60.0), (1e-3, 600.0)] {
        let fmu = Fmu::stepping();
        let mut t = 0.0;
        while t < end {
            assert_eq!(fmu.step(t, h), Status::Ok, "{:?}", fmu.messages().last());
            t += h;
        }
        assert_eq!(fmu.last_time(), t);
    }
    for h in [1e-4 / 3.0, 1e-5 / 7.0] {
        let fmu = Fmu::stepping();
        for k in 0..100_000 {
            let nanoseconds = |k: i32| (f64::from(k) * h * 1e9).round() * 1e-9;
            assert_eq!(
                fmu.step(nanoseconds(k), h),
                Status::Ok,
                "{:?}",
                fmu.messages().last()
            );
        }
    }
}

/// An importer that keeps its own time by index, where the FMU would have added: what the 10⁻⁶ of
/// before refused.
#[test]
#[cfg_attr(miri, ignore = "too long for an interpreter")]
fn a_sum_and_an_index_are_the_same_clock() {
    let fmu = Fmu::stepping();
    let (mut sum, h) = (0.0, 1e-4);
    for k in 0..600_000 {
        let t = if k % 1000 == 999 {
            sum
        } else {
            f64::from(k) * h
        };
        assert_eq!(fmu.step(t, h), Status::Ok, "{:?}", fmu.messages().last());
        sum += h;
    }
}

#[test]
fn the_stop_time_is_not_passed() {
    let fmu = Fmu::instantiated();
    fmu.setup(0.0, Some(1.0));
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    fmu.start();
    for k in 0..9 {
        assert_eq!(fmu.step(f64::from(k) * 0.1, 0.1), Status::Ok);
    }
    refused(&fmu, 0.9, 0.2, "passes the stop time; it must end by 1 s");
    assert_eq!(fmu.step(0.9, 0.1), Status::Ok);
    refused(
        &fmu,
        1.0,
        0.1,
        "the step from 1 s by 0.1 s passes the stop time",
    );
}

/// Both an importer that computes t_k = k h and one that adds up, over 10⁶ steps of a step that
/// binary cannot hold. The sum of the second is 10⁻⁹ s off (its rounding, not ours); a layer with a
/// clock of its own would be told of a jump.
#[test]
#[cfg_attr(miri, ignore = "too long for an interpreter")]
fn no_rounding_adds_up() {
    let (by_index, by_sum) = (Fmu::stepping(), Fmu::stepping());
    let h = 1e-3;
    let mut t = 0.0;
    for k in 0..1_000_000 {
        assert_eq!(by_index.step(f64::from(k) * h, h), Status::Ok);
        assert_eq!(by_sum.step(t, h), Status::Ok);
        t += h;
    }
    assert_eq!(by_index.last_time(), 999_999.0 * h + h);
    assert_eq!(by_sum.last_time(), t);
    assert_ne!(by_sum.last_time(), by_index.last_time());
}

#[test]
fn a_large_start_time_leaves_room_for_rounding() {
    let fmu = Fmu::instantiated();
    fmu.setup(1e9, None);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    fmu.start();
    for k in 0..100 {
        assert_eq!(
            fmu.step(1e9 + f64::from(k) * 1e-3, 1e-3),
            Status::Ok,
            "{:?}",
            fmu.messages()
        );
    }
}

#[test]
fn a_step_the_model_cannot_do_is_discarded() {
    let fmu = Fmu::stepping();
    assert_eq!(fmu.set(&[vr::U[0]], &[2.0]), Status::Ok);
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    assert_eq!(fmu.derivatives(&[vr::U[0]], &[1], &[4.0]), Status::Ok);
    assert_eq!(fmu.set_integer(vr::FAULT, 2), Status::Ok);
    let before = fmu.snapshot();
    assert_eq!(fmu.step(0.5, 0.5), Status::Discard);
    let message = fmu.last();
    assert_eq!(
        (message.status, message.category.as_str()),
        (Status::Discard, "logStatusDiscard")
    );
    assert_eq!(
        message.text,
        "fmi2DoStep: t = 0.5 s, h = 0.5 s: no step for fault = 2"
    );
    assert_eq!(fmu.snapshot(), before);
    assert_eq!(fmu.last_time(), 0.5);
    let (mut status, mut terminated) = (Status::Ok, -1);
    // SAFETY: a live instance, places for the results.
    unsafe {
        assert_eq!(
            fmi2GetStatus(fmu.c, DO_STEP_STATUS, &mut status),
            Status::Ok
        );
        assert_eq!(
            fmi2GetBooleanStatus(fmu.c, TERMINATED, &mut terminated),
            Status::Ok
        );
    }
    assert_eq!((status, terminated), (Status::Discard, 0));
    // A smaller step from the same point, with the derivative still pending: 1 + 2·0.25 +
    // 4·0.25²/2.
    assert_eq!(fmu.set_integer(vr::FAULT, 0), Status::Ok);
    assert_eq!(fmu.step(0.5, 0.25), Status::Ok);
    assert_eq!(fmu.get([vr::X[0]]), [1.625]);
    // Times of messages have no rest of a rounding error.
    assert_eq!(fmu.step(0.75, 0.3), Status::Ok);
    assert_eq!(fmu.step(1.05, 0.1), Status::Ok);
    assert_eq!(fmu.last_time(), 1.150_000_000_000_000_1);
    assert_eq!(fmu.set_integer(vr::FAULT, 2), Status::Ok);
    assert_eq!(fmu.step(fmu.last_time(), 0.1 + 0.2), Status::Discard);
    let text = "fmi2DoStep: t = 1.15 s, h = 0.3 s: no step for fault = 2";
    assert_eq!(fmu.last().text, text);
}

#[test]
fn a_warning_is_logged_and_the_step_is_ok() {
    let fmu = Fmu::stepping();
    assert_eq!(fmu.set_integer(vr::FAULT, 3), Status::Ok);
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    let message = fmu.last();
    assert_eq!(
        (message.status, message.category.as_str()),
        (Status::Warning, "logStatusWarning")
    );
    assert_eq!(message.text, "careful in step");
}

/// What FMI 2.0 has for a model that stops early: fmi2Discard, the time it reached, and whether it
/// wants the end.
#[test]
fn a_model_may_end_a_step_or_the_simulation() {
    let fmu = Fmu::stepping();
    let terminated = || {
        let mut value = -1;
        // SAFETY: a live instance, a place.
        let status = unsafe { fmi2GetBooleanStatus(fmu.c, TERMINATED, &mut value) };
        assert_eq!(status, Status::Ok);
        value
    };
    assert_eq!(fmu.set(&[vr::U[0]], &[2.0]), Status::Ok);
    assert_eq!(fmu.set_integer(vr::FAULT, 8), Status::Ok);
    assert_eq!(fmu.step(0.0, 0.5), Status::Discard);
    assert_eq!(
        fmu.last().text,
        "fmi2DoStep: t = 0 s, h = 0.5 s: the model stops at 0.25 s"
    );
    assert_eq!((fmu.last_time(), terminated()), (0.25, 0));
    assert_eq!(fmu.get([vr::X[0]]), [0.5]);
    assert_eq!(fmu.set_integer(vr::FAULT, 10), Status::Ok);
    assert_eq!(fmu.step(0.25, 0.5), Status::Ok, "all of the step");
    assert_eq!((fmu.last_time(), terminated()), (0.75, 0));
    assert_eq!(fmu.set_integer(vr::FAULT, 9), Status::Ok);
    assert_eq!(fmu.step(0.75, 0.5), Status::Discard);
    assert_eq!((fmu.last_time(), terminated()), (1.25, 1));
    assert_eq!(fmu.call(fmi2Reset), Status::Ok);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    fmu.start();
    assert_eq!(terminated(), 0);
}
