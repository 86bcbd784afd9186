//! Analytic derivatives of the outputs against finite differences, at seeded random points.
use emla::{Drive, Electric, Emla, Input, Output, Residual, State, Surrogate};
use machine_file::Machine;

use crate::random::Random;

/// An output's name, how to read it, and the size against which its derivative's error counts.
type Row = (&'static str, fn(&Output) -> f64, f64);

const ROWS: &[Row] = &[
    ("F", |y| y.F, 1e4),
    ("F_mean", |y| y.F_mean, 1.0),
    ("F_phys", |y| y.F_phys, 1e4),
    ("F_hyb", |y| y.F_hyb, 1e4),
    ("x_rod", |y| y.x_rod, 1e-2),
    ("x_rod_dot", |y| y.x_rod_dot, 1e-2),
    ("i_d", |y| y.i_d, 1.0),
    ("i_q", |y| y.i_q, 1.0),
    ("theta_m", |y| y.theta_m, 1.0),
    ("w_m", |y| y.w_m, 1.0),
    ("tau_e", |y| y.tau_e, 1.0),
    ("P_in", |y| y.P_in, 1e2),
    ("P_out", |y| y.P_out, 1e2),
    ("P_loss", |y| y.P_loss, 2e3),
    ("P_copper", |y| y.P_copper, 1.0),
    ("P_core", |y| y.P_core, 1.0),
    ("P_inverter", |y| y.P_inverter, 1.0),
    ("P_mech", |y| y.P_mech, 2e3),
    ("E_in", |y| y.E_in, 1.0),
    ("E_out", |y| y.E_out, 1.0),
    ("E_loss", |y| y.E_loss, 1.0),
    ("E_stored", |y| y.E_stored, 10.0),
    ("F_net", |y| y.F_net, 1e4),
    ("x_dot_net", |y| y.x_dot_net, 1e-2),
    ("x_dot_hyb", |y| y.x_dot_hyb, 1e-2),
    ("efficiency", |y| y.efficiency, 1e-2),
    ("efficiency_phys", |y| y.efficiency_phys, 1e-2),
    ("efficiency_net", |y| y.efficiency_net, 1e-2),
];

/// A field of the input, with a step that keeps central differences above rounding.
type Direction = (&'static str, fn(&mut Input) -> &mut f64, f64);

const DIRECTIONS: &[Direction] = &[
    ("v_d", |u| &mut u.v_d, 1e-2),
    ("v_q", |u| &mut u.v_q, 1e-2),
    ("x", |u| &mut u.x, 1e-8),
    ("x_dot", |u| &mut u.x_dot, 1e-7),
    ("F_ext", |u| &mut u.F_ext, 1.0),
    ("F_hold", |u| &mut u.F_hold, 1.0),
];

/// A point in one of the four quadrants, away from the kinks; every third beyond the voltage
/// circle; every eighth with a screw so heavy that its acceleration counts in the gear.
fn point(random: &mut Random, k: usize, drive: Drive) -> (Emla, State, Input) {
    // Both are 1 in the reference, by which multiplying and dividing are the same.
    let mut p = machine_file::Emla {
        w_C: 0.8,
        w_eta: 1.2,
        ..Machine::reference().emla.lift
    };
    if k.is_multiple_of(8) {
        p.J_s *= 1e3;
    }
    let emla = Emla::new(p, drive).expect("valid");
    let volts = if k.is_multiple_of(3) { 900.0 } else { 150.0 };
    let mut u = Input {
        x: random.within(0.05, 0.75),
        x_dot: random.within(0.01, 0.07) * random.within(-1.0, 1.0).signum(),
        F_hold: random.within(5e3, 70e3) * random.within(-1.0, 1.0).signum(),
        ..Input::default()
    };
    let start = emla.start(&u).expect("finite");
    let state = State {
        i_d: random.within(-5.0, 5.0),
        i_q: start.i_q * random.within(0.9, 1.2),
        w_m: start.w_m * random.within(0.95, 1.05),
        ..start
    };
    u.v_d = random.within(-volts, volts);
    u.v_q = random.within(-volts, volts);
    u.F_ext = random.within(-70e3, 70e3);
    (emla, state, u)
}

/// Central differences; their error is rounding (1e-16 of the output over the step) plus curvature.
#[test]
fn directional_derivatives_match_differences() {
    let mut random = Random::new(7);
    for (k, drive) in (0..300).flat_map(|k| [(k, Drive::Motion), (k, Drive::Force)]) {
        let (emla, mut s, mut u) = point(&mut random, k, drive);
        s.lead = random.within(0.0, 2e-3); // a force that is predicted
        if k.is_multiple_of(7) {
            s.x_dot *= 50.0; // so fast that the stiffness changes under the predicted force
            u.x_dot *= 50.0;
        }
        for &(input, field, step) in DIRECTIONS {
            let moved = |by: f64| {
                let mut u = u;
                *field(&mut u) += by;
                emla.output(&s, &u)
            };
            let (up, down) = (moved(step), moved(-step));
            let mut du = Input::default();
            *field(&mut du) = step;
            let along = emla.output_along(&s, &u, &du);
            for &(output, get, scale) in ROWS {
                let numeric = (get(&up) - get(&down)) / 2.0;
                let (analytic, tol) = (get(&along), 1e-8 * scale + 2e-6 * numeric.abs());
                assert!(
                    (analytic - numeric).abs() < tol,
                    "{drive:?} {k}: d{output}/d{input} = {analytic:e}, numerically {numeric:e}, at {s:?} {u:?}"
                );
            }
        }
    }
}

/// One-sided third-order differences along the model's own steps, with all inputs changing. (Second
/// order is not enough: the free rod's jerk makes the damper's power turn within 0.1 ms.)
#[test]
fn time_derivatives_match_differences() {
    let (mut random, mut slow) = (Random::new(8), Random::new(9));
    let h = 2e-7;
    for (k, drive) in (0..300).flat_map(|k| [(k, Drive::Motion), (k, Drive::Force)]) {
        let (emla, mut s, mut u) = point(&mut random, k, drive);
        if k.is_multiple_of(4) {
            // So slow that gear and friction turn over.
            s.w_m = emla.params().w_eta * slow.within(-1.5, 1.5);
            u.x_dot = emla::maps::travel_per_radian(emla.params()) * s.w_m;
        }
        s.residual = Residual {
            F_net: u.F_hold * slow.within(0.5, 0.9),
            x_dot_net: u.x_dot * slow.within(0.5, 0.9),
            ..Residual::default()
        };
        let u_dot = Input {
            v_d: random.within(-1e4, 1e4),
            v_q: random.within(-1e4, 1e4),
            x_dot: random.within(-1.0, 1.0),
            F_ext: random.within(-1e6, 1e6),
            ..Input::default()
        };
        let later = |t: f64| Input {
            v_d: u.v_d + t * u_dot.v_d,
            v_q: u.v_q + t * u_dot.v_q,
            x: u.x + t * (u.x_dot + t / 2.0 * u_dot.x_dot),
            x_dot: u.x_dot + t * u_dot.x_dot,
            F_ext: u.F_ext + t * u_dot.F_ext,
            ..u
        };
        let after = |t: f64| {
            let s = State {
                F_mean: s.F_mean,
                residual: s.residual, // held over a step
                ..emla.step(&s, later, 0.0, t).expect("finite")
            };
            emla.output(&s, &later(t))
        };
        let (y0, y1, y2, y3) = (
            emla.output(&s, &u),
            after(h),
            after(2.0 * h),
            after(3.0 * h),
        );
        let dot = emla.output_dot(&s, &u, &u_dot);
        for &(output, get, scale) in ROWS {
            let numeric =
                (18.0 * get(&y1) - 11.0 * get(&y0) - 9.0 * get(&y2) + 2.0 * get(&y3)) / (6.0 * h);
            let (analytic, tol) = (get(&dot), 1e-2 * scale + 3e-4 * numeric.abs());
            assert!(
                (analytic - numeric).abs() < tol,
                "{drive:?} {k}: d{output}/dt = {analytic:e}, numerically {numeric:e}, at {s:?} {u:?}"
            );
        }
    }
}

/// The tangent of the rates for Model Exchange, in each state and input, with the network in them
/// and resistance and flux that follow the temperatures; every fourth point with a brake that
/// slips. Central differences; the network's slopes are differences too, over 1e-4.
#[test]
fn rates_have_their_tangents() {
    let mut random = Random::new(11);
    for (k, drive) in (0..60).flat_map(|k| [(k, Drive::Motion), (k, Drive::Force)]) {
        let (emla, mut s, mut u) = point(&mut random, k, drive);
        let alpha = [0.0, 0.5][k % 2];
        let emla = emla
            .with_surrogate(Surrogate::reference(), alpha)
            .with_electric(Electric {
                heat: true,
                temperature: true,
                ..Electric::default()
            });
        (s.thermal.T_winding, s.thermal.T_housing) = (350.0, 320.0);
        u.brake = k.is_multiple_of(4);
        let slip = if u.brake { s.w_m.signum() } else { 0.0 };
        let x = s.moving();
        let sizes = [
            1.0, 1.0, 0.01, 1.0, 1e-4, 1e-2, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
        ];
        let rates = |s: &State, u: &Input| emla.derivative(s, u, slip).moving();
        let scales = [
            1e3, 1e3, 1e2, 1e3, 0.1, 10.0, 1e3, 1e3, 1e3, 1.0, 1.0, 1e2, 10.0,
        ];
        let check = |what: &str, up: &[f64], down: &[f64], along: &State| {
            for (j, found) in along.moving().into_iter().enumerate() {
                let numeric = (up[j] - down[j]) / 2.0;
                let tol = 2e-6 * numeric.abs() + 2e-9 * scales[j];
                assert!(
                    (found - numeric).abs() < tol,
                    "{drive:?} {k}: rate {j} by {what} = {found:e}, numerically {numeric:e}"
                );
            }
        };
        for (i, size) in sizes.into_iter().enumerate() {
            let step = 1e-4 * size;
            let at = |by: f64| {
                let (mut x, mut moved) = (x, s);
                x[i] += by;
                moved.set_moving(&x);
                rates(&moved, &u)
            };
            let (mut seed, mut ds) = ([0.0; State::MOVING], State::default());
            seed[i] = step;
            ds.set_moving(&seed);
            let along = emla.derivative_along(&s, &u, slip, (&ds, &Input::default()));
            check(&format!("state {i}"), &at(step), &at(-step), &along);
        }
        for &(input, field, step) in DIRECTIONS {
            let at = |by: f64| {
                let mut u = u;
                *field(&mut u) += by;
                rates(&s, &u)
            };
            let mut du = Input::default();
            *field(&mut du) = step;
            let along = emla.derivative_along(&s, &u, slip, (&State::default(), &du));
            check(input, &at(step), &at(-step), &along);
        }
    }
}
