//! Orders of the methods, tolerances, and what is carried from one step to the next.

use crate::problem::{Answer, Problem, solver};
use fmu_solver::{Method, Solver, SparsityPattern};

/// x₁' = −2 t x₁², x₂' = x₁ x₂ with x₁ = 1/(1 + t²), x₂ = e^(arctan t): neither linear nor without
/// t.
fn curve(t: f64, x: &[f64], dx: &mut [f64]) -> Answer {
    dx[0] = -2.0 * t * x[0] * x[0];
    dx[1] = x[0] * x[1];
    Ok(())
}

fn exact(t: f64) -> [f64; 2] {
    [1.0 / (1.0 + t * t), t.atan().exp()]
}

/// From t = 0.5 to 1.5 in `n` communication steps, each of one internal step: no error is too
/// large.
fn in_equal_steps(method: &Method, n: u32) -> f64 {
    let mut solver = solver(method, 2, 0, 1.0, 1e9);
    let (h, mut x) = (1.0 / f64::from(n), exact(0.5));
    for k in 0..n {
        let t = 0.5 + f64::from(k) * h;
        let mut problem = Problem::new(|s, x: &[f64], dx: &mut [f64]| curve(t + s, x, dx));
        solver
            .advance(&mut problem, (t, h), &mut x, &mut { h })
            .unwrap();
    }
    assert_eq!(solver.counts().steps, u64::from(n));
    let end = exact(1.5);
    (0..2).map(|i| (x[i] - end[i]).abs()).fold(0.0, f64::max)
}

/// Half the step leaves an error of 2⁻ᵖ, p the order. The next term of the error is some h of the
/// first, h = 1/16 s: half an order.
#[test]
fn errors_fall_with_the_order_of_the_method() {
    for (method, order, n) in [
        (Method::Fixed, 4.0, 16),
        (Method::Adaptive, 5.0, 16),
        (Method::Stiff(SparsityPattern::full(2)), 5.0, 16),
    ] {
        let errors = [n, 2 * n].map(|n| in_equal_steps(&method, n));
        let found = (errors[0] / errors[1]).log2();
        assert!(
            (found - order).abs() < 0.5,
            "{method:?}: {found} {errors:?}"
        );
        assert!(errors[1] > 1e-13, "{method:?}: rounding: {errors:?}");
    }
}

/// The error of each internal step is held below the tolerance; over a second the equations do not
/// amplify it by more than e, and there are fewer than 100 steps. That it is not far below shows
/// that the tolerance is what steps are chosen by.
#[test]
fn the_tolerance_is_kept_and_used() {
    for method in [Method::Adaptive, Method::Stiff(SparsityPattern::full(2))] {
        let mut last = f64::INFINITY;
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let mut solver = solver(&method, 2, 0, f64::INFINITY, tolerance);
            let (mut x, mut first) = (exact(0.0), 0.0);
            solver
                .advance(&mut Problem::new(curve), (0.0, 2.0), &mut x, &mut first)
                .unwrap();
            let end = exact(2.0);
            let error = (0..2)
                .map(|i| (x[i] - end[i]).abs() / end[i].max(1.0))
                .fold(0.0, f64::max);
            let steps = solver.counts().steps;
            assert!(
                error < 10.0 * tolerance,
                "{method:?} {tolerance:e}: {error:e} in {steps}"
            );
            assert!(
                error > 1e-4 * tolerance && error < last,
                "{method:?} {tolerance:e}: {error:e} in {steps}"
            );
            assert!(first > 0.0 && steps < 100, "{first} {steps}");
            last = error;
        }
    }
}

/// The classical method is written out once more, as it was in version 0.1 of this crate.
#[test]
fn the_fixed_method_has_the_bits_it_had() {
    let plus = |x: [f64; 2], factor: f64, rate: [f64; 2]| [0, 1].map(|i| x[i] + factor * rate[i]);
    let rate = |t: f64, x: [f64; 2]| {
        let mut dx = [0.0; 2];
        curve(t, &x, &mut dx).unwrap();
        dx
    };
    let (t, h, longest) = (0.3, 0.7, 0.032);
    let mut x = exact(0.3);
    let n: f64 = 22.0; // 0.7/0.032 and what is left
    let dt = h / n;
    for k in 0..n as u32 {
        let s = f64::from(k) * dt;
        let (half, end) = (s + 0.5 * dt, s + dt);
        let a = rate(t + s, x);
        let b = rate(t + half, plus(x, 0.5 * dt, a));
        let c = rate(t + half, plus(x, 0.5 * dt, b));
        let d = rate(t + end, plus(x, dt, c));
        x = plus(
            plus(plus(plus(x, dt / 6.0, a), dt / 3.0, b), dt / 3.0, c),
            dt / 6.0,
            d,
        );
    }
    let mut found = exact(0.3);
    let mut problem = Problem::new(|s, x: &[f64], dx: &mut [f64]| curve(t + s, x, dx));
    let mut solver = solver(&Method::Fixed, 2, 0, longest, 1e-6);
    solver
        .advance(&mut problem, (t, h), &mut found, &mut 0.0)
        .unwrap();
    assert_eq!(found.map(f64::to_bits), x.map(f64::to_bits));
    assert_eq!(problem.evaluations.get(), 4 * 22);
}

/// A solver made anew goes on from states and first step as the old one would have, bit for bit.
#[test]
fn states_and_the_first_step_are_all_that_is_carried() {
    for method in [
        Method::Fixed,
        Method::Adaptive,
        Method::Stiff(SparsityPattern::full(2)),
    ] {
        let make = || solver(&method, 2, 0, 0.03, 1e-7);
        let (mut old, mut x, mut first) = (make(), exact(0.0), 0.0);
        let step = |solver: &mut Solver, k: u32, x: &mut [f64], first: &mut f64| {
            let t = 0.1 * f64::from(k);
            let mut problem = Problem::new(move |s, x: &[f64], dx: &mut [f64]| curve(t + s, x, dx));
            solver.advance(&mut problem, (t, 0.1), x, first).unwrap();
        };
        (0..5).for_each(|k| step(&mut old, k, &mut x, &mut first));
        let (mut y, mut restored) = (x, first);
        let mut new = make();
        for k in 5..10 {
            step(&mut old, k, &mut x, &mut first);
            step(&mut new, k, &mut y, &mut restored);
        }
        assert_eq!((x, first), (y, restored), "{method:?}");
    }
}
