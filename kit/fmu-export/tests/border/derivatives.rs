//! Input, output and directional derivatives.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;

/// Oracle: ∫(2 + 3s + 5s²/2 + 7s³/6) ds over h = 0.5, all numbers exact in binary.
#[test]
fn input_derivatives_act_for_one_step() {
    let fmu = Fmu::stepping();
    let u = vr::U[0];
    assert_eq!(fmu.set(&[u], &[2.0]), Status::Ok);
    assert_eq!(
        fmu.derivatives(&[u, u, u], &[1, 2, 3], &[3.0, 5.0, 7.0 * 3.0]),
        Status::Ok
    );
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    let h: f64 = 0.5;
    let x = 2.0 * h + 3.0 * h * h / 2.0 + 5.0 * h.powi(3) / 6.0 + 21.0 * h.powi(4) / 24.0;
    // 4 rounded terms of size 1.
    assert!((fmu.get([vr::X[0]])[0] - x).abs() < 4.0 * f64::EPSILON);
    // What was set is read back; what acts has gone on to the end of the step and is held from
    // there: 2 + 3h + 5h²/2 + 21h³/6.
    assert_eq!(fmu.get([u]), [2.0]);
    let end = 2.0 + 3.0 * h + 5.0 * h * h / 2.0 + 21.0 * h.powi(3) / 6.0;
    let (status, x_dot) = fmu.output_derivative(vr::X[0], 1); // x₁' is the input itself
    assert_eq!(status, Status::Ok);
    assert!((x_dot - end).abs() < 8.0 * f64::EPSILON);
    let [x_end] = fmu.get([vr::X[0]]);
    assert_eq!(fmu.step(0.5, 0.5), Status::Ok);
    assert_eq!(fmu.get([u, vr::X[0]]), [2.0, x_end + 0.5 * x_dot]);
}

/// Each input has derivatives of its own: a set ends them, those of another input do not.
#[test]
fn derivatives_are_kept_per_input() {
    let fmu = Fmu::stepping();
    let [u_1, u_2] = vr::U;
    let slope = |expected: f64| {
        assert_eq!(fmu.output_derivative(vr::Y, 1), (Status::Ok, expected));
    };
    assert_eq!(fmu.derivatives(&vr::U, &[1, 1], &[3.0, 5.0]), Status::Ok);
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok); // to u = 1.5, 2.5
    let x_dot = || 3.0 * fmu.output_derivative(vr::X[0], 1).1; // the share of x₁ in y'
    slope(x_dot() + 5.0);
    // A derivative of u₁ leaves the slope at which u₂ has arrived.
    assert_eq!(fmu.derivatives(&[u_1], &[1], &[7.0]), Status::Ok);
    slope(x_dot() + 5.0);
    // A plain set of u₂ ends it, and sets u₂ alone.
    assert_eq!(fmu.set(&[u_2], &[2.5]), Status::Ok);
    slope(x_dot());
    assert_eq!(x_dot(), 3.0 * 1.5);
    // And so for what was given for the step to come.
    assert_eq!(fmu.derivatives(&[u_2], &[1], &[9.0]), Status::Ok);
    slope(x_dot() + 9.0);
    assert_eq!(fmu.set(&[u_2], &[2.5]), Status::Ok);
    slope(x_dot());
    assert_eq!(fmu.step(0.5, 0.5), Status::Ok);
    assert_eq!(x_dot(), 3.0 * (1.5 + 7.0 * 0.5));
    slope(x_dot());
}

/// What is held after the step must be what the importer could have set itself.
#[test]
fn input_derivatives_that_leave_the_bounds_discard_the_step() {
    for slope in [-3e6, 1e308] {
        let fmu = Fmu::stepping();
        let u = vr::U[0]; // at least -1e6
        assert_eq!(
            fmu.derivatives(&[u, u], &[1, 2], &[slope, slope]),
            Status::Ok
        );
        let before = fmu.snapshot();
        assert_eq!(fmu.step(0.0, 100.0), Status::Discard);
        let text = fmu.last().text;
        assert!(
            text.contains("the derivatives of `u[1]` take it to"),
            "{text}"
        );
        assert_eq!(fmu.snapshot(), before);
    }
    let fmu = Fmu::stepping();
    assert_eq!(fmu.derivatives(&[vr::U[0]], &[1], &[-3e6]), Status::Ok);
    assert_eq!(fmu.step(0.0, 0.25), Status::Ok); // to -0.75e6
}

#[test]
fn output_derivatives_see_the_slope_of_the_inputs() {
    let fmu = Fmu::stepping();
    let u = vr::U[1];
    assert_eq!(fmu.output_derivative(vr::Y, 1), (Status::Ok, 0.0));
    assert_eq!(fmu.derivatives(&[u, u], &[1, 2], &[3.0, 4.0]), Status::Ok);
    assert_eq!(fmu.output_derivative(vr::Y, 1), (Status::Ok, 3.0)); // given for the step to come
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    assert_eq!(fmu.output_derivative(vr::Y, 1), (Status::Ok, 5.0)); // at its end: 3 + 4·0.5
    assert_eq!(fmu.step(0.5, 0.5), Status::Ok);
    assert_eq!(fmu.output_derivative(vr::Y, 1), (Status::Ok, 0.0)); // held
}

#[test]
fn directional_derivatives_go_through() {
    let fmu = Fmu::stepping();
    let known = [vr::U[1], vr::U[0], vr::U[1]]; // named twice: seeds add up
    let (status, dy) = fmu.directional(&[vr::Y, vr::X[0]], &known, &[2.0, 5.0, 0.5]);
    assert_eq!((status, dy), (Status::Ok, vec![2.5, 0.0]));
}

#[test]
fn derivatives_of_the_wrong_things_are_refused() {
    let fmu = Fmu::stepping();
    let refused = |status: Status, text: &str| {
        assert_eq!(status, Status::Error, "{text}");
        assert!(
            fmu.last().text.contains(text),
            "`{}` lacks `{text}`",
            fmu.last().text
        );
    };
    let before = fmu.snapshot();
    #[rustfmt::skip]
    let inputs = [
        (vr::U[0],  0, 1.0,           "`u[1]`: order of derivative = 0 must be at least 1"),
        (vr::U[1], -1, 1.0,           "`u[2]`: order of derivative = -1"),
        (vr::HELD,  1, 1.0,           "`held` is a Real input without derivatives; it must be a continuous Real input"),
        (vr::FAULT, 1, 1.0,           "`fault` is an Integer input without derivatives"),
        (vr::GAIN,  1, 1.0,           "`gain` is a Real tunable parameter without derivatives"),
        (77,        1, 1.0,           "unknown value reference 77"),
    ];
    for (wrong, order, value, text) in inputs {
        refused(
            fmu.derivatives(&[vr::U[0], wrong], &[1, order], &[9.0, value]),
            text,
        );
    }
    assert_eq!(fmu.snapshot(), before);
    refused(
        fmu.output_derivative(vr::Y, 2).0,
        "order of derivative = 2 must be 1",
    );
    refused(
        fmu.output_derivative(vr::U[0], 1).0,
        "`u[1]` is a Real input; it must be a Real output",
    );
    refused(
        fmu.output_derivative(vr::DOUBLED, 1).0,
        "`doubled` is an Integer output; it must be a Real output",
    );
    refused(
        fmu.directional(&[vr::Y], &[vr::GAIN], &[1.0]).0,
        "known `gain` is a Real tunable parameter; it must be a Real input",
    );
    refused(
        fmu.directional(&[vr::LAW], &[vr::U[0]], &[1.0]).0,
        "unknown `law` is an Integer fixed parameter; it must be a Real output",
    );
    let discarded = |status: Status, text: &str| {
        assert_eq!(status, Status::Discard, "{text}");
        assert!(fmu.last().text.contains(text), "{text}");
    };
    discarded(
        fmu.directional(&[vr::Y], &[vr::U[0]], &[f64::INFINITY]).0,
        "known `u[1]`: seed = inf must be finite",
    );
    discarded(
        fmu.derivatives(&[vr::U[1]], &[1], &[f64::NAN]),
        "`u[2]`: derivative of order 1 = NaN must be finite",
    );
    assert_eq!(fmu.snapshot(), before);
}

/// FMI 2.0 declares no highest order of input derivatives: those beyond the ones in use are left
/// out, which is said once.
#[test]
fn derivatives_of_high_order_are_left_out() {
    let (fmu, plain) = (Fmu::stepping(), Fmu::stepping());
    let u = vr::U[0];
    let said = |fmu: &Fmu| {
        let about = |m: &&Message| m.text.contains("derivatives of order 4 are left out");
        fmu.messages().iter().filter(about).count()
    };
    for k in 0..3 {
        assert_eq!(fmu.derivatives(&[u, u], &[4, 1], &[1e3, 3.0]), Status::Ok);
        assert_eq!(plain.derivatives(&[u], &[1], &[3.0]), Status::Ok);
        for fmu in [&fmu, &plain] {
            assert_eq!(fmu.step(f64::from(k), 1.0), Status::Ok);
        }
        assert_eq!(fmu.get(vr::X), plain.get(vr::X));
    }
    assert_eq!((said(&fmu), said(&plain)), (1, 0));
}

/// Bounds hold within the step: u = −0.75e6 at both ends, and −1.25e6 in the middle.
#[test]
fn input_derivatives_that_leave_the_bounds_on_the_way_discard_the_step() {
    let fmu = Fmu::stepping();
    let u = vr::U[0]; // at least -1e6
    assert_eq!(fmu.set(&[u], &[-0.75e6]), Status::Ok);
    assert_eq!(fmu.derivatives(&[u, u], &[1, 2], &[-2e6, 4e6]), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0), Status::Discard);
    let text = fmu.last().text;
    assert!(
        text.contains("take it to -1250000; it must be finite and at least -1000000"),
        "{text}"
    );
    assert_eq!(fmu.step(0.0, 0.125), Status::Ok);
}

/// In Initialization Mode y depends on u₂ directly, and x on its start alone: no part of it is
/// through the initialization here, so the answer is that of the step mode, to the accuracy of the
/// difference.
#[test]
fn directional_derivatives_are_given_during_initialization() {
    let fmu = Fmu::initializing();
    let (status, dy) = fmu.directional(&[vr::Y, vr::X[0]], &[vr::U[1]], &[2.5]);
    assert_eq!(status, Status::Ok);
    assert!((dy[0] - 2.5).abs() < 1e-9 && dy[1] == 0.0, "{dy:?}");
    assert_eq!(fmu.get(vr::U), [0.0, 0.0]);
}
