//! Values through the life of an instance; the same numbers as through the border of FMI 2.0.

use crate::client::Fmu;
use crate::client3::*;
use crate::probe::vr;
use fmu_export::ffi as client;
use std::ffi::CStr;

/// Value reference of time, which comes after all that a table can have.
const TIME: u32 = 65536;

#[test]
fn the_version_is_that_of_the_standard() {
    // SAFETY: a static C string.
    assert_eq!(unsafe { CStr::from_ptr(fmi3GetVersion()) }, c"3.0");
}

/// Oracle: x_dot is constant, so x = x0 + t (u + rate), exact in binary for these numbers. A row is
/// one array.
#[test]
fn a_run_gives_the_closed_form() {
    let fmu = Fmu3::initializing(PLAIN);
    assert_eq!(
        fmu.set(
            &[vr::RATE[0], vr::U[0], vr::GAIN],
            &[0.5, 0.25, 1.25, 0.0, 2.0]
        ),
        Status::Ok
    );
    assert_eq!(fmu.get(&[vr::X[0]]), [0.0, 0.25]);
    assert_eq!(fmu.call(fmi3ExitInitializationMode), Status::Ok);
    for k in 0..8 {
        let t = f64::from(k) * 0.125;
        assert_eq!(fmu.get(&[TIME]), [t]);
        let end = Step {
            event: false,
            terminate: false,
            early: false,
            last: t + 0.125,
        };
        assert_eq!(fmu.step(t, 0.125), (Status::Ok, end));
    }
    assert_eq!(
        fmu.get(&[vr::X[0], vr::Y, TIME, vr::INNER]),
        [1.75, 0.5, 3.5, 1.0, 2.25]
    );
    assert_eq!(fmu.call(fmi3Terminate), Status::Ok);
    assert_eq!(fmu.get(&[vr::Y]), [3.5]);
    let text: Vec<_> = fmu.messages().into_iter().map(|m| m.text).collect();
    assert_eq!(text, ["initialized", "terminated"]);
}

#[test]
fn all_types_pass_through() {
    let fmu = Fmu3::initializing(EVENTS);
    assert_eq!(fmu.set_int64(vr::LAW, 2), Status::Ok);
    assert_eq!(fmu.set_int32(vr::LEVEL, -3), Status::Ok);
    assert_eq!(fmu.set_boolean(vr::ENABLED, 0), Status::Ok);
    assert_eq!(fmu.call(fmi3ExitInitializationMode), Status::Ok);
    assert_eq!(fmu.set_int32(vr::FAULT, 21), Status::Ok);
    assert_eq!(fmu.set_boolean(vr::SWITCH, 255), Status::Ok);
    assert_eq!(fmu.get_int64(vr::LAW), (Status::Ok, 2));
    assert_eq!(
        [vr::LEVEL, vr::FAULT, vr::DOUBLED].map(|v| fmu.get_int32(v).1),
        [-3, 21, 42]
    );
    assert_eq!(
        [vr::ENABLED, vr::SWITCH, vr::ON].map(|v| fmu.get_boolean(v).1),
        [0, 1, 1]
    );
    assert_eq!(fmu.get_string(vr::FILE), (Status::Ok, "4".to_owned()));
}

/// Before initialization, what is given has its start value, and what is computed has none.
#[test]
fn start_values_are_read_before_initialization() {
    let fmu = Fmu3::instantiated(PLAIN);
    assert_eq!(
        fmu.get(&[vr::HELD, vr::RATE[0], TIME]),
        [1.5, 0.0, 0.25, 0.0]
    );
    assert_eq!(fmu.get_int64(vr::LAW), (Status::Ok, 1));
    assert_eq!(fmu.try_get::<1>(&[vr::Y]).0, Status::Error);
    assert_eq!(
        fmu.last().text,
        "fmi3GetFloat64: `y` is a Float64 output and has no value before initialization"
    );
}

#[test]
fn a_file_in_the_resources_is_found_by_its_path() {
    let fmu = Fmu3::instantiated(PLAIN);
    assert_eq!(fmu.set_string(vr::FILE, c"5"), Status::Ok);
    // The probe's law is 2 only where the folder is what the importer said.
    assert_eq!(fmu.get_int64(vr::LAW), (Status::Ok, 2));
    assert_eq!(fmu.get_int32(vr::LEVEL), (Status::Ok, 5));
}

/// Both borders are over one core: equal inputs give equal bits.
#[test]
fn both_versions_give_the_same_numbers() {
    const STEPS: i32 = if cfg!(miri) { 10 } else { 200 };
    let (two, three) = (Fmu::stepping(), Fmu3::stepping(EVENTS));
    let mut u = [0.1, -0.7];
    for k in 0..STEPS {
        u = [u[1] * 1.01 + 0.3, u[0] * 0.97 - 0.1];
        assert_eq!(two.set(&vr::U, &u), client::Status::Ok);
        assert_eq!(three.call(fmi3EnterEventMode), Status::Ok);
        assert_eq!(three.set(&[vr::U[0]], &u), Status::Ok);
        let same = || {
            let a = two.get([vr::X[0], vr::X[1], vr::Y, vr::INNER]);
            let b: [f64; 4] = three.get(&[vr::X[0], vr::Y, vr::INNER]);
            assert_eq!(a.map(f64::to_bits), b.map(f64::to_bits), "step {k}");
        };
        same();
        assert_eq!(three.update().0, Status::Ok);
        assert_eq!(three.call(fmi3EnterStepMode), Status::Ok);
        let t = f64::from(k) * 0.01;
        assert_eq!(two.step(t, 0.01), client::Status::Ok);
        assert_eq!(three.step(t, 0.01).0, Status::Ok);
        same();
    }
}

/// A model that stops half way: an early return for who allows it; else the step goes on to its
/// end.
#[test]
fn a_model_that_stops_returns_early_or_goes_on() {
    let early = Fmu3::stepping(EVENTS);
    assert_eq!(early.set_int32(vr::FAULT, 8), Status::Ok);
    let (status, step) = early.step(0.0, 1.0);
    assert_eq!(
        (status, step),
        (
            Status::Ok,
            Step {
                event: true,
                terminate: false,
                early: true,
                last: 0.5
            }
        )
    );
    assert_eq!(early.get(&[TIME]), [0.5]);
    assert_eq!(early.step(0.5, 0.25).1.last, 0.625);

    let whole = Fmu3::stepping(PLAIN);
    assert_eq!(whole.set_int32(vr::FAULT, 8), Status::Ok);
    assert_eq!(whole.set(&[vr::U[0]], &[1.0, 1.0]), Status::Ok);
    // Halves of what is left: the last of them is too small to move the time.
    let (status, step) = whole.step(0.0, 1.0);
    assert!(
        status == Status::Ok && !step.early && step.last == 1.0,
        "{step:?} {:?}",
        whole.messages()
    );
    assert_eq!(whole.get(&[vr::X[0]]), [1.0, 1.5]);
}

#[test]
fn events_and_the_end_of_the_simulation_are_told() {
    let fmu = Fmu3::stepping(EVENTS);
    assert_eq!(fmu.set_int32(vr::FAULT, 9), Status::Ok);
    let end = Step {
        event: true,
        terminate: true,
        early: false,
        last: 1.0,
    };
    assert_eq!(fmu.step(0.0, 1.0), (Status::Ok, end));
    let without = Fmu3::stepping(PLAIN);
    assert_eq!(without.set_int32(vr::FAULT, 9), Status::Ok);
    assert_eq!(
        without.step(0.0, 1.0),
        (
            Status::Ok,
            Step {
                event: false,
                ..end
            }
        )
    );
}

#[test]
fn a_step_that_cannot_be_done_leaves_the_instance_as_it_was() {
    let fmu = Fmu3::stepping(PLAIN);
    assert_eq!(fmu.set_int32(vr::FAULT, 2), Status::Ok);
    let before = fmu.snapshot();
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Discard);
    assert_eq!(
        fmu.last().text,
        "fmi3DoStep: t = 0 s, h = 1 s: no step for fault = 2"
    );
    assert_eq!(fmu.snapshot(), before);
    assert_eq!(fmu.step(0.5, 1.0).0, Status::Error);
    assert!(
        fmu.last()
            .text
            .contains("time = 0.5 s must be the present time 0 s")
    );
    assert_eq!(fmu.step(0.0, 0.0).0, Status::Error);
    assert_eq!(fmu.step(0.0, f64::NAN).0, Status::Error);
    assert_eq!(fmu.snapshot(), before);
}

#[test]
fn a_panic_is_an_error_of_its_instance_only() {
    let (fmu, other) = (Fmu3::stepping(PLAIN), Fmu3::stepping(PLAIN));
    let good = fmu.save();
    assert_eq!(fmu.set_int32(vr::FAULT, 1), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Error);
    let text = fmu.last().text;
    assert!(
        text.starts_with("fmi3DoStep: panic: asked to in step")
            && text.ends_with("needs fmi3Reset or fmi3SetFMUState"),
        "{text}"
    );
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Error);
    assert!(
        fmu.last()
            .text
            .contains("not allowed in state lost by a panic")
    );
    assert_eq!(other.step(0.0, 1.0).0, Status::Ok);
    assert_eq!(fmu.restore(good), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Ok);
    assert_eq!(fmu.set_int32(vr::FAULT, 1), Status::Ok);
    assert_eq!(fmu.step(1.0, 1.0).0, Status::Error);
    assert_eq!(fmu.call(fmi3Reset), Status::Ok);
    assert_eq!(fmu.enter_initialization(0.0, Some(2.0)), Status::Ok);
    assert_eq!(fmu.call(fmi3ExitInitializationMode), Status::Ok);
    assert_eq!(fmu.step(0.0, 3.0).0, Status::Error);
    assert!(
        fmu.last().text.contains("it must end by 2 s"),
        "{:?}",
        fmu.last()
    );
}
