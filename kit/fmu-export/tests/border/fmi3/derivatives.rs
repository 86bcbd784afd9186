//! Directional, adjoint and output derivatives, and dependencies, all for arrays.

use crate::client3::*;
use crate::probe::vr;

/// y = gain x[1] + u[2] at fixed state; x depends on no input.
#[test]
fn directional_and_adjoint_derivatives_are_transposes() {
    for fmu in [Fmu3::stepping(PLAIN), Fmu3::initialized(EVENTS)] {
        let unknowns = [vr::X[0], vr::Y];
        let knowns = [vr::U[0], vr::HELD];
        let (seed, weights) = ([0.5, -1.25, 3.0], [0.75, 1.5, -2.0]);
        let (status, dy) = fmu.directional(&unknowns, &knowns, &seed, 3);
        assert_eq!((status, &dy[..]), (Status::Ok, &[0.0, 0.0, -1.25][..]));
        let (status, du) = fmu.adjoint(&unknowns, &knowns, &weights, 3);
        assert_eq!((status, &du[..]), (Status::Ok, &[0.0, -2.0, 0.0][..]));
        // ⟨w, J s⟩ = ⟨Jᵀ w, s⟩, exact for these numbers.
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert_eq!(dot(&weights, &dy), dot(&du, &seed));
    }
}

/// In Initialization Mode both are differences through the whole initialization; the probe's is
/// linear. Tolerance: ε^⅔ of values of 1.
#[test]
fn they_are_transposes_in_initialization_mode_too() {
    let fmu = Fmu3::initializing(PLAIN);
    let (status, dy) = fmu.directional(&[vr::Y], &[vr::U[0]], &[0.5, 2.0], 1);
    assert_eq!(status, Status::Ok);
    assert!((dy[0] - 2.0).abs() < 1e-9, "{dy:?}");
    let (status, du) = fmu.adjoint(&[vr::Y], &[vr::U[0]], &[3.0], 2);
    assert_eq!(status, Status::Ok);
    assert!(du[0].abs() < 1e-9 && (du[1] - 3.0).abs() < 1e-9, "{du:?}");
}

#[test]
fn wrong_derivatives_are_refused() {
    let fmu = Fmu3::stepping(PLAIN);
    let refused = |status: Status, text: &str| {
        assert_eq!(status, Status::Error);
        assert!(fmu.last().text.contains(text), "{}", fmu.last().text);
    };
    let (y, u) = ([vr::Y], [vr::U[0]]);
    refused(fmu.directional(&y, &u, &[1.0], 1).0, "nSeed = 1 must be 2");
    refused(
        fmu.directional(&y, &u, &[1.0; 2], 2).0,
        "nSensitivity = 2 must be 1",
    );
    refused(fmu.adjoint(&y, &u, &[1.0; 2], 2).0, "nSeed = 2 must be 1");
    refused(
        fmu.adjoint(&y, &u, &[1.0], 1).0,
        "nSensitivity = 1 must be 2",
    );
    refused(
        fmu.directional(&y, &[vr::GAIN], &[1.0], 1).0,
        "known `gain` is a Float64 tunable parameter; it must be a Float64 input",
    );
    refused(
        fmu.adjoint(&y, &[vr::GAIN], &[1.0], 1).0,
        "known `gain` is a Float64 tunable parameter; it must be a Float64 input",
    );
    refused(
        fmu.directional(&u, &u, &[1.0; 2], 2).0,
        "unknown `u[1]` is a Float64 input; it must be a Float64 output",
    );
    refused(
        fmu.adjoint(&u, &u, &[1.0; 2], 2).0,
        "unknown `u[1]` is a Float64 input; it must be a Float64 output",
    );
    assert_eq!(fmu.adjoint(&y, &u, &[f64::NAN], 2).0, Status::Discard);
    assert!(
        fmu.last()
            .text
            .contains("unknown `y`: seed = NaN must be finite")
    );
    refused(
        fmu.output_derivatives(&[vr::X[0]], &[2], 2).0,
        "`x[1]`: order of derivative = 2 must be 1",
    );
    refused(
        fmu.output_derivatives(&[vr::X[0]], &[1], 1).0,
        "nValues = 1 must be 2",
    );
}

#[test]
fn output_derivatives_are_of_all_elements() {
    let fmu = Fmu3::stepping(PLAIN);
    assert_eq!(fmu.set(&[vr::U[0]], &[2.0, 5.0]), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Ok);
    // x_dot = u + rate, y_dot = gain x_dot[1].
    assert_eq!(
        fmu.output_derivatives(&[vr::X[0], vr::Y], &[1, 1], 3),
        (Status::Ok, vec![2.0, 5.25, 6.0])
    );
}

/// The table's own words, element by element.
#[test]
fn dependencies_are_told_by_element() {
    let fmu = Fmu3::initializing(PLAIN);
    let parameters = [
        (vr::GAIN, 1),
        (vr::RATE[0], 1),
        (vr::RATE[0], 2),
        (vr::LAW, 1),
        (vr::LEVEL, 1),
        (vr::ENABLED, 1),
        (vr::FILE, 1),
    ];
    let mut x = vec![(1, vr::RATE[0], 1)];
    x.extend(parameters.map(|(vr, element)| (2, vr, element)));
    assert_eq!(fmu.dependencies(vr::X[0]), (Status::Ok, x));
    assert_eq!(
        fmu.dependencies(vr::Y),
        (
            Status::Ok,
            vec![(1, vr::GAIN, 1), (1, vr::U[0], 1), (1, vr::U[0], 2)]
        )
    );
    assert_eq!(fmu.call(fmi3ExitInitializationMode), Status::Ok);
    assert_eq!(fmu.dependencies(vr::X[0]), (Status::Ok, vec![]));
    assert_eq!(
        fmu.dependencies(vr::Y),
        (Status::Ok, vec![(1, vr::U[0], 2), (1, vr::FAULT, 1)])
    );
    // What does not say depends on all inputs.
    let all = [
        (vr::U[0], 1),
        (vr::U[0], 2),
        (vr::HELD, 1),
        (vr::FAULT, 1),
        (vr::SWITCH, 1),
    ];
    assert_eq!(
        fmu.dependencies(vr::DOUBLED),
        (Status::Ok, all.map(|(vr, e)| (1, vr, e)).to_vec())
    );
    assert_eq!(fmu.dependencies(vr::U[0]).0, Status::Error);
    assert!(
        fmu.last()
            .text
            .contains("`u[1]` is a Float64 input; it must be a variable of ModelStructure")
    );
}
