//! Tests of the network's evaluation, its guards and the refusals of its file.

use super::*;
use crate::maps;
use serde_json::Value;

const REFERENCE: &str = include_str!("../../../../parameters/surrogate.json");

fn reference_file() -> Value {
    serde_json::from_str(REFERENCE).expect("JSON")
}

/// Oracle: NumPy, `tests/oracle/surrogate_inference.py`. Scaled outputs of order 1 leave the last
/// layer after some thousand rounded operations; 1e-12 of the range covers both summation orders.
#[test]
fn evaluation_matches_numpy() {
    let text = include_str!("../../../../tests/oracle/surrogate_inference.json");
    let golden: Value = serde_json::from_str(text).expect("JSON");
    let surrogate = Surrogate::reference();
    let rows = golden["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 300);
    for row in rows {
        let [tau, w, f, x_dot] = std::array::from_fn(|k| row[k].as_f64().expect("number"));
        let y = surrogate.evaluate(tau, w);
        assert!(
            (y.F - f).abs() < 1.4e5 * 1e-12,
            "F at {tau} N·m, {w} rad/s: {} vs {f}",
            y.F
        );
        assert!(
            (y.x_dot - x_dot).abs() < 0.07 * 1e-12,
            "x_dot at {tau}, {w}"
        );
    }
}

/// The number of points evaluated together must not show: a point just inside the double
/// evaluation near standstill and the same point alone have the same forward bits.
#[test]
fn batches_have_the_same_bits() {
    let surrogate = Surrogate::reference();
    let [alone] = surrogate.sliding([[12.3, 45.6]]);
    let [first, second] = surrogate.sliding([[12.3, 45.6], [-7.8, 90.1]]);
    let [other] = surrogate.sliding([[-7.8, 90.1]]);
    assert_eq!((alone, other), (first, second));
}

/// From three directions of motion to six: near standstill both of a point count.
#[test]
fn three_points_at_once_have_the_bits_of_each() {
    let surrogate = Surrogate::reference();
    let speeds = [-90.0, -41.0, -3.7, -0.0, 0.2, 17.0, 55.0, 300.0];
    let mut tau_e = -13.0;
    for a in speeds {
        for b in speeds {
            for c in speeds {
                tau_e = if tau_e > 13.0 { -13.1 } else { tau_e + 0.17 };
                let points = [[tau_e, a], [-0.7 * tau_e, b], [tau_e + 1.3, c]];
                let each = points.map(|[tau_e, w_m]| surrogate.evaluate(tau_e, w_m));
                assert_eq!(surrogate.evaluate_three(points), each, "{points:?}");
            }
        }
    }
    let [wrong, right, _] = surrogate.evaluate_three([[f64::NAN, 1.0], [1.0, 1.0], [1.0, 2.0]]);
    assert!(wrong.F.is_nan());
    assert_eq!(right, surrogate.evaluate(1.0, 1.0));
}

/// Whether three actuators share a network, which a restored state does not, or have different
/// ones, is not seen in their residuals.
#[test]
fn residuals_of_three_are_those_of_each() {
    let actuator = |surrogate: &Surrogate| {
        let p = machine_file::Machine::reference().emla.lift;
        let emla = crate::Emla::new(p, crate::Drive::Motion).expect("the reference machine");
        emla.with_surrogate(surrogate.clone(), 0.5)
    };
    let mut file = Surrogate::reference().file();
    file.layers[5].bias[0] += 0.01;
    let (shipped, copy) = (
        Surrogate::reference(),
        Surrogate::new(file.clone()).unwrap(),
    );
    let twin = Surrogate::new(file).unwrap();
    let points = [[7.3, 41.0], [-2.9, -1.7], [5.1, 63.0]];
    for networks in [
        [&shipped, &shipped, &shipped],
        [&copy, &copy, &copy],
        [&copy, &twin, &copy],
        [&shipped, &copy, &shipped],
    ] {
        let actuators = networks.map(actuator);
        let each = [0, 1, 2].map(|i| actuators[i].residual(points[i][0], points[i][1]));
        assert_eq!(crate::Emla::residuals(&actuators, points), each);
    }
}

/// Reversing torque and speed reverses force and rod speed, bit for bit.
#[test]
fn odd_symmetry() {
    let surrogate = Surrogate::reference();
    for k in 0..200 {
        let (tau, w) = (0.31 * f64::from(k) - 30.0, 0.9 * f64::from(k % 37) - 2.0);
        let (a, b) = (surrogate.evaluate(tau, w), surrogate.evaluate(-tau, -w));
        assert!(
            (a.F + b.F).abs() < 1e-9 && (a.x_dot + b.x_dot).abs() < 1e-15,
            "{tau} {w}"
        );
        assert_eq!(a.in_trained_range, b.in_trained_range, "{tau} {w}");
    }
}

/// F_qs and the hybrid force at α = 0.9 for physics `p`.
fn forces(surrogate: &Surrogate, p: &machine_file::Emla, tau: f64, w: f64) -> (f64, f64) {
    let F_qs = |tau, w| maps::quasi_static_force(p, tau, w);
    let physics = F_qs(tau, w);
    let dF = surrogate.evaluate(tau, w).F - surrogate.guard(tau, w, F_qs);
    (physics, physics + 0.9 * dF)
}

/// Far outside: loads of ±80 kN from standstill to 0.1 m/s and back in reverse.
#[test]
fn hybrid_stays_near_the_physics_outside_the_range() {
    let surrogate = Surrogate::reference();
    let p = machine_file::Machine::reference().emla.lift;
    let mut worst: f64 = 0.0;
    for F in [-80e3, 80e3] {
        for k in -100..=100 {
            let w = f64::from(k) * 1e-3 / maps::travel_per_radian(&p);
            let tau = maps::required_torque(&p, F, w, 0.0);
            let (physics, hybrid) = forces(&surrogate, &p, tau, w);
            worst = worst.max(((hybrid - physics) / physics).abs());
        }
    }
    assert!(worst < 0.10, "{worst}");
    assert!(worst > 0.01, "the network adds nothing: {worst}");
}

/// No jump: the residual moves no faster than a physical slope allows. Per newton metre the map
/// itself gains N/lead = 2356 N; the residual is a correction of it, so a half of that is generous.
/// Per rad/s the friction of both directions is exchanged within a few rad/s: 2·4 kN over the
/// fold's width.
#[test]
fn hybrid_is_continuous() {
    let surrogate = Surrogate::reference();
    let p = machine_file::Machine::reference().emla.lift;
    let residual = |tau, w| {
        let F_qs = |tau, w| maps::quasi_static_force(&p, tau, w);
        surrogate.evaluate(tau, w).F - surrogate.guard(tau, w, F_qs)
    };
    let (d_tau, d_w) = (0.02, 0.05);
    for tau in [-60.0, -41.0, -20.0, -4.0, 0.0, 3.0, 17.0, 38.0, 55.0] {
        for k in -5_000..5_000 {
            let w = f64::from(k) * d_w;
            let jump = (residual(tau, w + d_w) - residual(tau, w)).abs();
            assert!(
                jump < 4000.0 * d_w,
                "{jump} N from {w} to {} rad/s at {tau} N·m",
                w + d_w
            );
        }
    }
    for w in [
        -240.0, -165.0, -50.0, -3.0, -0.5, 0.0, 0.7, 2.4, 30.0, 160.0, 240.0,
    ] {
        for k in -3_000..3_000 {
            let tau = f64::from(k) * d_tau;
            let jump = (residual(tau + d_tau, w) - residual(tau, w)).abs();
            assert!(
                jump < 1200.0 * d_tau,
                "{jump} N from {tau} to {} N·m",
                tau + d_tau
            );
        }
    }
}

#[test]
fn trained_range_and_nan() {
    let surrogate = Surrogate::reference();
    let at = |tau, w| surrogate.evaluate(tau, w).in_trained_range;
    assert!(at(10.0, 80.0) && at(-10.0, -80.0) && at(-20.0, 30.0));
    assert!(!at(60.0, 80.0) && !at(10.0, 240.0) && !at(10.0, 0.0) && !at(-36.0, 80.0));
    assert!(surrogate.evaluate(f64::NAN, 1.0).F.is_nan());
    assert!(surrogate.evaluate(1.0, f64::NAN).F.is_nan());
}

/// What is compiled in has the bits of the file.
#[test]
fn the_shipped_network_is_the_file() {
    let (shipped, read) = (
        Surrogate::reference(),
        Surrogate::from_json(REFERENCE).expect("valid"),
    );
    assert_eq!(shipped.file(), read.file());
    let bits = |surrogate: &Surrogate| -> Vec<u64> {
        let numbers = surrogate.file().layers.into_iter().flat_map(|layer| {
            let weights = layer.weights.into_iter().flatten();
            weights.chain(layer.bias).map(f64::to_bits)
        });
        numbers.collect()
    };
    assert_eq!(bits(&shipped), bits(&read));
    assert_eq!(
        shipped.evaluate(17.3, 61.9).F.to_bits(),
        read.evaluate(17.3, 61.9).F.to_bits()
    );
}

#[test]
fn file_survives_the_round_trip() {
    let surrogate = Surrogate::reference();
    let read = Surrogate::from_json(&surrogate.to_json()).expect("valid");
    assert_eq!(read, surrogate);
}

/// Every refusal says what is wrong and where.
#[test]
fn bad_files_are_refused() {
    let refuse = |change: &dyn Fn(&mut Value), reason: &str| {
        let mut file = reference_file();
        change(&mut file);
        let error = Surrogate::from_json(&file.to_string())
            .expect_err(reason)
            .to_string();
        assert!(error.contains(reason), "`{error}` does not say `{reason}`");
    };
    refuse(&|f| f["colour"] = 1.into(), "unknown field `colour`");
    refuse(
        &|f| f["training"]["mood"] = 1.into(),
        "unknown field `mood`",
    );
    refuse(&|f| f["layers"][0]["weights"] = 3.into(), "invalid type");
    refuse(
        &|f| drop(f.as_object_mut().expect("object").remove("ranges")),
        "missing field `ranges`",
    );
    refuse(
        &|f| drop(array(&mut f["layers"]).pop()),
        "`layers` has 5 elements, 6 are needed",
    );
    refuse(
        &|f| drop(array(&mut f["layers"][1]["weights"]).pop()),
        "`layers[1].weights` has 47 elements, 48 are needed",
    );
    refuse(
        &|f| array(&mut f["layers"][2]["weights"][5]).push(0.5.into()),
        "`layers[2].weights[5]` has 49 elements, 48 are needed",
    );
    refuse(
        &|f| drop(array(&mut f["layers"][5]["bias"]).pop()),
        "`layers[5].bias` has 1 elements, 2 are needed",
    );
    refuse(
        &|f| f["ranges"]["tau_e"]["max"] = (-1e3).into(),
        "min must lie below max",
    );
    refuse(
        &|f| f["ranges"]["w_m"]["min"] = (-3.0).into(),
        "speeds must not be negative",
    );
}

/// JSON has no NaN, so such a number can only come from a program.
#[test]
fn numbers_that_are_not_finite_are_refused() {
    let refuse = |change: &dyn Fn(&mut SurrogateFile), reason: &str| {
        let mut file = Surrogate::reference().file();
        change(&mut file);
        let error = Surrogate::new(file).expect_err(reason).to_string();
        assert!(error.contains(reason), "`{error}` does not say `{reason}`");
    };
    refuse(
        &|f| f.layers[3].weights[2][7] = f64::NAN,
        "`layers[3].weights[2][7]` = NaN",
    );
    refuse(
        &|f| f.layers[0].bias[9] = f64::INFINITY,
        "`layers[0].bias[9]` = inf",
    );
    refuse(
        &|f| f.ranges.f_ext.max = f64::NAN,
        "`ranges.F_ext.max` = NaN",
    );
    refuse(&|f| f.training.mse.test = f64::NAN, "`training.mse` = NaN");
}

fn array(value: &mut Value) -> &mut Vec<Value> {
    value.as_array_mut().expect("array")
}
