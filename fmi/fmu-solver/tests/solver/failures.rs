//! Steps that cannot be done.

use crate::problem::{Answer, Problem, solver};
use fmu_solver::{Failure, Method, SparsityPattern};

fn methods() -> [Method; 3] {
    [
        Method::Fixed,
        Method::Adaptive,
        Method::Stiff(SparsityPattern::full(1)),
    ]
}

/// x' = x², from 1: infinite at t = 1.
fn explosion(_: f64, x: &[f64], dx: &mut [f64]) -> Answer {
    dx[0] = x[0] * x[0];
    Ok(())
}

#[test]
fn a_step_that_fails_leaves_states_and_first_step() {
    for method in methods() {
        let is_fixed = matches!(method, Method::Fixed);
        let mut solver = solver(&method, 1, 0, 0.01, 1e-6);
        let (mut x, mut first) = ([1.0], 0.125);
        let failure = solver
            .advance(&mut Problem::new(explosion), (0.0, 1.5), &mut x, &mut first)
            .unwrap_err();
        match failure {
            Failure::NotFinite(0, value) if is_fixed => assert!(!value.is_finite()),
            Failure::TooShort(s, dt) if !is_fixed => {
                assert!((s - 1.0).abs() < 1e-3 && dt < 1e-10, "{s} {dt}");
            }
            other => panic!("{other:?}"),
        }
        assert_eq!((x, first), ([1.0], 0.125));
        // The next one is done as if nothing had happened.
        solver
            .advance(&mut Problem::new(explosion), (0.0, 0.5), &mut x, &mut first)
            .unwrap();
        assert!((x[0] - 2.0).abs() < 1e-4, "{x:?}");
    }
}

/// Where the system cannot be evaluated, shorter steps are tried, and in the end it says why.
#[test]
fn what_the_system_refuses_is_said_in_its_words() {
    for method in methods() {
        let mut solver = solver(&method, 1, 0, 0.01, 1e-6);
        let wall = |_: f64, x: &[f64], dx: &mut [f64]| {
            dx[0] = 1.0;
            if x[0] <= 0.35 {
                Ok(())
            } else {
                Err(format!("x = {} must be at most 0.35", x[0]))
            }
        };
        let (mut x, mut first) = ([0.0], 0.0);
        let failure = solver
            .advance(&mut Problem::new(wall), (0.0, 1.0), &mut x, &mut first)
            .unwrap_err();
        assert!(
            failure.to_string().ends_with(" must be at most 0.35"),
            "{failure}"
        );
        assert!(matches!(failure, Failure::System(_)), "{failure:?}");
        assert_eq!((x, first), ([0.0], 0.0));
        solver
            .advance(&mut Problem::new(wall), (0.0, 0.3), &mut x, &mut first)
            .unwrap();
        assert!((x[0] - 0.3).abs() < 1e-12, "{x:?}");
    }
}

#[test]
fn rejected_steps_are_counted() {
    for method in [Method::Adaptive, Method::Stiff(SparsityPattern::full(1))] {
        let mut solver = solver(&method, 1, 0, 1.0, 1e-9);
        let jump = |s: f64, _: &[f64], dx: &mut [f64]| {
            dx[0] = if s < 0.4 { 0.0 } else { 1.0 };
            Ok(())
        };
        let mut x = [0.0];
        solver
            .advance(&mut Problem::new(jump), (0.0, 1.0), &mut x, &mut 0.0)
            .unwrap();
        // Estimates are those of smooth courses: of a jump they see some hundredth.
        assert!((x[0] - 0.6).abs() < 1e-6, "{x:?}");
        assert!(solver.counts().rejected > 5, "{:?}", solver.counts());
    }
}

/// Of an oscillation that becomes ever faster, whose error is the same in all its phases, steps
/// grow shorter before one is rejected.
#[test]
fn steps_become_shorter_before_one_is_rejected() {
    for method in [Method::Adaptive, Method::Stiff(SparsityPattern::full(2))] {
        let mut solver = solver(&method, 2, 0, f64::INFINITY, 1e-8);
        let chirp = |s: f64, x: &[f64], dx: &mut [f64]| {
            (dx[0], dx[1]) = ((1.0 + s) * x[1], -(1.0 + s) * x[0]);
            Ok(())
        };
        let (mut x, mut first) = ([1.0, 0.0], 0.0);
        solver
            .advance(&mut Problem::new(chirp), (0.0, 20.0), &mut x, &mut first)
            .unwrap();
        let counts = solver.counts();
        assert_eq!(counts.rejected, 0, "{method:?} {counts:?}");
    }
}

#[test]
fn too_many_internal_steps_are_refused() {
    let mut solver = solver(&Method::Fixed, 1, 0, 0.25, 1e-6);
    let failure = solver
        .advance(
            &mut Problem::new(explosion),
            (0.0, 3e5),
            &mut [0.0],
            &mut 0.0,
        )
        .unwrap_err();
    let text =
        "1200000 internal steps of at most 0.25 s would be needed; there must be at most 1000000";
    assert_eq!(failure.to_string(), text);
}
