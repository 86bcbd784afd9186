//! Events by closed forms.

use crate::problem::{Answer, Problem, solver};
use fmu_solver::{Method, SparsityPattern};
use std::cell::Cell;

/// With the longest internal steps that the tests take.
fn methods() -> [(Method, f64); 3] {
    [
        (Method::Fixed, 1e-3),
        (Method::Adaptive, f64::INFINITY),
        (Method::Stiff(SparsityPattern::full(2)), f64::INFINITY),
    ]
}

/// Gravity, m/s².
const G: f64 = 9.81;

/// A ball without friction: height and speed.
fn fall(_: f64, x: &[f64], dx: &mut [f64]) -> Answer {
    (dx[0], dx[1]) = (x[1], -G);
    Ok(())
}

/// Nothing moves.
fn rest(_: f64, _: &[f64], dx: &mut [f64]) -> Answer {
    dx[0] = 0.0;
    Ok(())
}

fn height(_: f64, x: &[f64], z: &mut [f64]) {
    z[0] = x[0];
}

/// An oscillation x = cos(t), x' = −sin(t).
fn oscillation(_: f64, x: &[f64], dx: &mut [f64]) -> Answer {
    (dx[0], dx[1]) = (x[1], -x[0]);
    Ok(())
}

/// A ball falls from 1 m and is thrown back with a share e of its speed. It lands at √(2/g) times
/// 1, 1 + 2 e, 1 + 2 e + 2 e² and so on. A parabola is integrated exactly by all methods, and their
/// states between are exact too, so only rounding is left: some ε of the time, which begins at 100
/// s.
#[test]
fn a_ball_lands_when_it_should() {
    for (method, longest) in methods() {
        let e: f64 = 0.75;
        let mut solver = solver(&method, 2, 1, longest, 1e-9);
        let (mut x, mut first, mut now) = ([1.0, 0.0], 0.0, 100.0);
        let mut problem = Problem {
            f: fall,
            z: height,
            evaluations: 0.into(),
        };
        let mut landings = Vec::new();
        while landings.len() < 5 {
            let event = solver
                .advance(&mut problem, (now, 103.0 - now), &mut x, &mut first)
                .unwrap();
            now += event.expect("it lands five times in 3 s");
            if x[1] < 0.0 {
                landings.push(now);
                x[1] *= -e;
            }
        }
        let fall_time = (2.0 / G).sqrt();
        for (k, landing) in landings.iter().enumerate() {
            let exact = fall_time * (1.0 + 2.0 * (1..=k as i32).map(|k| e.powi(k)).sum::<f64>());
            let error = landing - 100.0 - exact;
            assert!(error.abs() < 2e-12, "{method:?} {k}: {landing} {error:e}");
        }
    }
}

/// Of two indicators the first to change stops the step, whatever their order; the other one
/// afterwards. Tolerance: that of the integration (1e-10 a step, some tens of them), the slope of
/// both is above 0.5.
#[test]
fn the_first_of_several_events_comes_first() {
    let times = [
        (2.0 * std::f64::consts::FRAC_PI_6),
        std::f64::consts::FRAC_PI_2,
    ];
    for (method, longest) in methods() {
        for swap in [0, 1] {
            let z = |_: f64, x: &[f64], z: &mut [f64]| {
                z[swap] = x[0] - 0.5;
                z[1 - swap] = -x[0];
            };
            let mut problem = Problem {
                f: oscillation,
                z,
                evaluations: 0.into(),
            };
            let mut solver = solver(&method, 2, 2, longest, 1e-10);
            let (mut x, mut first, mut now) = ([1.0, 0.0], 0.0, 0.0);
            for time in times {
                let event = solver
                    .advance(&mut problem, (now, 2.0 - now), &mut x, &mut first)
                    .unwrap();
                now += event.unwrap();
                assert!((now - time).abs() < 1e-9, "{method:?}: {now} {time}");
                let behind = [x[0] <= 0.5, x[0] < 0.0][usize::from(time > 1.5)];
                assert!(behind, "{x:?}");
            }
            let rest = solver
                .advance(&mut problem, (now, 2.0 - now), &mut x, &mut first)
                .unwrap();
            assert_eq!(rest, None);
            assert!((x[0] - 2.0_f64.cos()).abs() < 1e-8, "{x:?}");
        }
    }
}

/// How often an indicator is looked at to find where it changes its sign, to the last bits of the time:
/// a line at once, a curve as by the secant, and one that bends sharply or jumps, for which weights
/// help little, in at most four looks a bit.
#[test]
fn events_are_found_in_few_looks() {
    type Indicator = fn(f64) -> f64;
    let cases: [(Indicator, u32); 4] = [
        (|x| x - 0.3, 6),
        (|x| x.exp() - 1.35, 14),
        (|x| x.powi(9) - 1e-9, 50),
        (|x| if x < 0.3 { -1e9 } else { 1e-9 }, 4 * 52),
    ];
    for (k, (indicator, most)) in cases.into_iter().enumerate() {
        let looks = Cell::new(0);
        let z = |_: f64, x: &[f64], z: &mut [f64]| {
            looks.set(looks.get() + 1);
            z[0] = indicator(x[0]);
        };
        let ramp = |_: f64, _: &[f64], dx: &mut [f64]| {
            dx[0] = 1.0;
            Ok(())
        };
        let mut problem = Problem {
            f: ramp,
            z,
            evaluations: 0.into(),
        };
        let mut solver = solver(&Method::Fixed, 1, 1, 1.0, 1e-9);
        let event = solver.advance(&mut problem, (0.0, 1.0), &mut [0.0], &mut 0.0);
        assert!(event.unwrap().is_some());
        println!("{k}: {} looks", looks.get());
        assert!(looks.get() <= most, "{k}: {} looks", looks.get());
    }
}

/// States between are of order 4 (error in time h⁵), of the fixed method of order 3 (h⁴): within
/// one step of h the error falls accordingly, to within half an order. The event is at a fixed
/// share of the step.
#[test]
fn states_between_have_their_order() {
    for (method, order) in [
        (Method::Fixed, 4.0),
        (Method::Adaptive, 5.0),
        (Method::Stiff(SparsityPattern::full(2)), 5.0),
    ] {
        let errors = [0.1, 0.05].map(|h: f64| {
            let start: f64 = 0.6;
            let limit = (start + 0.37 * h).cos();
            let z = |_: f64, x: &[f64], z: &mut [f64]| z[0] = x[0] - limit;
            let mut problem = Problem {
                f: oscillation,
                z,
                evaluations: 0.into(),
            };
            let mut solver = solver(&method, 2, 1, 1.0, 1e9);
            let mut x = [start.cos(), -start.sin()];
            let event = solver
                .advance(&mut problem, (0.0, h), &mut x, &mut { h })
                .unwrap()
                .unwrap();
            (event - 0.37 * h).abs()
        });
        let found = (errors[0] / errors[1]).log2();
        assert!(
            (found - order).abs() < 0.5,
            "{method:?}: {found} {errors:?}"
        );
    }
}

/// An indicator that jumps, and one as flat as a fifth power: found as well, in few evaluations.
#[test]
fn indicators_of_any_shape_are_located() {
    for shape in [
        (|d: f64| d.signum()) as fn(f64) -> f64,
        |d| d.powi(5),
        |d| (50.0 * d).exp() - 1.0,
    ] {
        let count = std::cell::Cell::new(0);
        let z = |s: f64, _: &[f64], z: &mut [f64]| {
            count.set(count.get() + 1);
            z[0] = shape(0.3 - s);
        };
        let mut problem = Problem {
            f: oscillation,
            z,
            evaluations: 0.into(),
        };
        let mut solver = solver(&Method::Adaptive, 2, 1, 1.0, 1e-3);
        let event = solver
            .advance(&mut problem, (0.0, 1.0), &mut [1.0, 0.0], &mut 1.0)
            .unwrap();
        assert!((event.unwrap() - 0.3).abs() < 1e-14, "{event:?}");
        assert!(count.get() < 230, "{}", count.get());
    }
}

/// A ball whose flights become shorter than the internal step, until their lengths are those of
/// rounded times: each landing is found, at √(2/g) (1 + 2 e + 2 e² + …), and it stays above the floor.
/// Landings are rounded to some ε of the time, which their number multiplies.
#[test]
fn short_flights_are_found() {
    for (method, longest) in [
        (Method::Fixed, 0.01),
        (Method::Adaptive, f64::INFINITY),
        (Method::Stiff(SparsityPattern::full(2)), f64::INFINITY),
    ] {
        for e in [0.1, 0.7_f64] {
            let mut solver = solver(&method, 2, 1, longest, 1e-6);
            let (mut x, mut first, mut now) = ([1.0, 0.0], 0.0, 0.0);
            let mut problem = Problem {
                f: fall,
                z: height,
                evaluations: 0.into(),
            };
            let (fall_time, mut bounces, mut exact) = ((2.0 / G).sqrt(), 0, (2.0 / G).sqrt());
            // 5.0 s is long after the last bounce, so it ends only where no event is found.
            for k in 0..150 {
                let found = solver.advance(&mut problem, (now, 5.0 - now), &mut x, &mut first);
                let Some(event) = found.unwrap() else {
                    panic!("{method:?} {e}: lost after {k} events at {now}: {x:?}");
                };
                assert_eq!(solver.event_indicator(), Some(0));
                now += event;
                let error = (now - exact).abs();
                assert!(error < 1e-12, "{method:?} {e} {k}: {now} {exact}");
                assert!(x[0].abs() < 1e-13, "{method:?} {e} {k}: {x:?}");
                // Flights that rounded times cannot tell apart may end while it still rises.
                if x[1] < 0.0 {
                    x[1] *= -e;
                    bounces += 1;
                    exact += 2.0 * fall_time * e.powi(bounces);
                }
            }
            assert!(bounces > 12, "{method:?} {e}: {bounces}");
        }
    }
}

/// An indicator that is crossed and crossed back within one internal step: by a parabola (a throw
/// above a ceiling), and by the trough of a wave. The first crossing is the event.
#[test]
fn two_crossings_within_a_step_are_found() {
    for (method, longest) in [
        (Method::Fixed, 1.0),
        (Method::Adaptive, f64::INFINITY),
        (Method::Stiff(SparsityPattern::full(2)), f64::INFINITY),
    ] {
        for at in [0.1, 0.43, 0.8] {
            // From a height of 1 m; highest at `at`, by 1e-4 m above the ceiling.
            let mut solver = solver(&method, 2, 1, longest, 1e-6);
            let ceiling = 1.0 + 0.5 * G * at * at - 1e-4;
            let z = |_: f64, x: &[f64], z: &mut [f64]| z[0] = ceiling - x[0];
            let mut problem = Problem {
                f: fall,
                z,
                evaluations: 0.into(),
            };
            let event = solver
                .advance(&mut problem, (0.0, 1.0), &mut [1.0, G * at], &mut 1.0)
                .unwrap();
            let exact = at - (2e-4_f64 / G).sqrt();
            let error = (event.expect("above the ceiling") - exact).abs();
            assert!(error < 1e-9, "{method:?} {at}: {error:e}");
        }
    }
}

/// An indicator of time alone that has changed its sign, and changes it back long after: what is looked
/// at right after the event is the time right after it, so the second change is an event too. Nothing
/// is integrated, so both are found to some ε of the time.
#[test]
fn an_indicator_that_returns_late_has_two_events() {
    let (from, until) = (0.2, 0.55);
    let now = Cell::new(0.0);
    let z = |s: f64, _: &[f64], z: &mut [f64]| {
        z[0] = (now.get() + s - from) * (until - now.get() - s);
    };
    let mut problem = Problem {
        f: rest,
        z,
        evaluations: 0.into(),
    };
    let mut solver = solver(&Method::Adaptive, 1, 1, f64::INFINITY, 1e-6);
    let (mut x, mut first) = ([1.0], 1.0);
    for exact in [from, until] {
        let span = (now.get(), 1.0 - now.get());
        let event = solver.advance(&mut problem, span, &mut x, &mut first);
        let event = event.unwrap().expect("the sign changes");
        now.set(now.get() + event);
        assert!((now.get() - exact).abs() < 1e-14, "{now:?} {exact}");
    }
    let span = (now.get(), 1.0 - now.get());
    let event = solver.advance(&mut problem, span, &mut x, &mut first);
    assert_eq!(event.unwrap(), None);
}

/// A trough that no parabola through the ends and the middle finds: looks approach it from both sides.
/// The first crossing is the first zero of the factor (s − m)² − d.
#[test]
fn a_lopsided_trough_is_found() {
    for m in [0.1_f64, 0.3, 0.7] {
        let z = |s: f64, _: &[f64], z: &mut [f64]| z[0] = ((s - m).powi(2) - 3e-4) * (1.0 + s);
        let mut problem = Problem {
            f: rest,
            z,
            evaluations: 0.into(),
        };
        let mut solver = solver(&Method::Adaptive, 1, 1, f64::INFINITY, 1e-6);
        let event = solver.advance(&mut problem, (0.0, 1.0), &mut [1.0], &mut 1.0);
        let error = event.unwrap().expect("the trough") - (m - 3e-4_f64.sqrt());
        assert!(error.abs() < 1e-13, "{m}: {error:e}");
    }
}
