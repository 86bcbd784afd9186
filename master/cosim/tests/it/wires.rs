//! What a connection does to a value on its way, and values that are no Reals, on the coupled mass
//! and spring.

use cosim::master::{Master, Schedule};
use cosim::structure::system::System;

use super::support::{link, oscillator, oscillator_links, settings, ssd, stepping, system};

const SCHEDULES: [Schedule; 4] = [
    Schedule::Standard,
    Schedule::GaussSeidel,
    Schedule::Jacobi,
    Schedule::JacobiDerivatives,
];
const H: f64 = 0.01;

fn master(system: &System, schedule: Schedule) -> Master {
    let start = [
        "spring.k=23",
        "spring.d=0.9",
        "mass.m=1.7",
        "mass.x_dot_start=-0.83",
    ];
    let settings = settings(system, &start).unwrap();
    Master::new(system, &settings, stepping(H, schedule)).unwrap()
}

fn number(system: &System, master: &Master, name: &str) -> f64 {
    master.number(system.port(name).unwrap()).unwrap()
}

/// A spring that sees twice the motion and whose force counts half is the same spring; factors that
/// are powers of two round nothing, so the run and the power of the bond are the same bit for bit.
#[test]
fn factors_that_cancel_change_nothing() {
    let factor = |f: &str| format!("<ssc:LinearTransformation factor=\"{f}\"/>");
    let scaled = ssd(&oscillator_links(&factor("2"), &factor("0.5"), ""));
    let (plain, scaled) = (
        system("plain", &oscillator()).unwrap(),
        system("scaled", &scaled).unwrap(),
    );
    for schedule in SCHEDULES {
        let (mut a, mut b) = (master(&plain, schedule), master(&scaled, schedule));
        for _ in 0..100 {
            a.step().unwrap();
            b.step().unwrap();
        }
        for name in ["mass.x", "mass.x_dot"] {
            let (a, b) = (number(&plain, &a, name), number(&scaled, &b, name));
            assert_eq!(a, b, "{schedule:?} {name}");
        }
        assert_eq!(a.residuals(), b.residuals(), "{schedule:?}");
        assert!(a.residuals()[0].energy != 0.0, "{schedule:?}");
        let force = number(&scaled, &b, "spring.F");
        assert_eq!(force, 2.0 * number(&plain, &a, "spring.F"), "{schedule:?}");
    }
}

/// An offset shifts where the spring is at rest: c·k of force at the start. The derivative of a
/// shifted value is that of the value.
#[test]
fn an_offset_shifts_a_value_and_not_its_derivative() {
    let shifted = link(
        ("mass", "x"),
        ("spring", "x"),
        "<ssc:LinearTransformation factor=\"3\" offset=\"-0.25\"/>",
    ) + &link(("spring", "F"), ("mass", "f"), "");
    let system = system("shifted", &ssd(&shifted)).unwrap();
    let mut master = master(&system, Schedule::JacobiDerivatives);
    assert_eq!(number(&system, &master, "spring.x"), 2.75);
    master.step().unwrap();
    // F = −k(x_s − d), held derivative −k·3·v: a first step of order two in h, exact for these
    // polynomials.
    let (force, slope) = (-23.0 * 2.75, 23.0 * 3.0 * 0.83);
    let x = 1.0 - 0.83 * H + H * H * (force / 2.0 + H * slope / 6.0) / 1.7;
    let found = number(&system, &master, "mass.x");
    assert!((found - x).abs() < 4.0 * f64::EPSILON, "{found} {x}");
}

/// Jacobi's map with a spring that is off left of zero and one stronger each step.
#[test]
fn booleans_and_integers_are_passed() {
    let links = oscillator_links("", "", "")
        + &link(("mass", "is_left"), ("spring", "off"), "")
        + &link(("mass", "steps"), ("spring", "stage"), "");
    let system = system("discrete", &ssd(&links)).unwrap();
    let mut master = master(&system, Schedule::Jacobi);
    let (mut x, mut v) = (1.0, -0.83);
    let mut were_left = 0;
    for k in 0..150 {
        let force = if x < 0.0 {
            0.0
        } else {
            -23.0 * f64::from(1 + k) * x - 0.9 * v
        };
        were_left += u32::from(x < 0.0);
        let a = force / 1.7;
        (x, v) = (x + H * (v + H * a / 2.0), v + H * a);
        master.step().unwrap();
        let found = number(&system, &master, "mass.x");
        // Some ten rounded operations a step on a position below 2 m, and no growth: the spring
        // only ever loses its force.
        assert!(
            (found - x).abs() < 1e3 * 2.0 * f64::EPSILON,
            "{k}: {found} {x}"
        );
        assert_eq!(number(&system, &master, "spring.off"), f64::from(x < 0.0));
        assert_eq!(number(&system, &master, "spring.stage"), f64::from(k + 1));
    }
    assert!(0 < were_left && were_left < 150, "{were_left}");
}

/// Where the component draws the power, what the coupling lost is what it else created.
#[test]
fn a_bond_that_draws_turns_the_sign_of_its_residual() {
    let drawn = ssd(&oscillator_links("", "", "power=\"drawn\""));
    let (plain, drawn) = (
        system("delivers", &oscillator()).unwrap(),
        system("draws", &drawn).unwrap(),
    );
    let (mut a, mut b) = (
        master(&plain, Schedule::GaussSeidel),
        master(&drawn, Schedule::GaussSeidel),
    );
    a.step().unwrap();
    b.step().unwrap();
    let (a, b) = (&a.residuals()[0], &b.residuals()[0]);
    assert!(a.energy < 0.0 && b.energy == -a.energy && a.turnover == b.turnover);
}
