//! Identities that exact dynamics must satisfy: energy, power, inverses, orders, derivatives.

use crate::seeded::{Random, plant};
use hdrm::{DOF, Hdrm, Input, Load, Options, Output, State};
use machine_file::Machine;
use nalgebra::{DVector, Matrix6, Vector6};

fn moved(state: &State, zeta_ddot: &[f64; DOF], s: f64) -> State {
    let State { zeta, zeta_dot, .. } = state;
    State {
        zeta: std::array::from_fn(|i| zeta[i] + s * zeta_dot[i] + 0.5 * s * s * zeta_ddot[i]),
        zeta_dot: std::array::from_fn(|i| zeta_dot[i] + s * zeta_ddot[i]),
        ..*state
    }
}

/// Bare mechanism (no friction, no stops, no forces) by RK4: largest energy error and kinetic
/// energy, J, over `n` steps of `h`.
fn unforced(zeta: [f64; DOF], zeta_dot: [f64; DOF], h: f64, n: usize) -> (f64, f64) {
    let machine = Machine::reference();
    let hdrm = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid reference");
    let state = |q: Vector6<f64>, w: Vector6<f64>| State {
        zeta: q.into(),
        zeta_dot: w.into(),
        ..State::default()
    };
    let rate = |q, w| {
        let (M, h) = hdrm.equations_of_motion(&state(q, w));
        M.cholesky().expect("positive definite").solve(&-h)
    };
    let (mut q, mut w) = (Vector6::from(zeta), Vector6::from(zeta_dot));
    let start = hdrm.energies(&state(q, w));
    let (mut worst, mut most_kinetic): (f64, f64) = (0.0, 0.0);
    for _ in 0..n {
        let a1 = rate(q, w);
        let w2 = w + a1 * (h / 2.0);
        let a2 = rate(q + w * (h / 2.0), w2);
        let w3 = w + a2 * (h / 2.0);
        let a3 = rate(q + w2 * (h / 2.0), w3);
        let w4 = w + a3 * h;
        let a4 = rate(q + w3 * h, w4);
        q += (w + (w2 + w3) * 2.0 + w4) * (h / 6.0);
        w += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
        let (kinetic, potential) = hdrm.energies(&state(q, w));
        most_kinetic = most_kinetic.max(kinetic);
        worst = worst.max((kinetic + potential - start.0 - start.1).abs());
    }
    (worst, most_kinetic)
}

/// Swinging about the pose in which the machine hangs: 1e-6 J over 10 s at 1 ms is the requirement.
#[test]
fn unforced_energy_drifts_less_than_a_microjoule() {
    let hanging = [0.0, -1.6, 0.0, 0.0, -0.1, -0.67];
    let push = [0.9, 0.6, -0.9, 0.7, 1.1, -1.2];
    let (worst, kinetic) = unforced(hanging, push, 1e-3, 10_000);
    println!("energy drift {worst:e} J with up to {kinetic} J kinetic");
    assert!(kinetic > 300.0, "the machine must move: {kinetic} J");
    assert!(worst < 1e-6, "{worst:e} J");
}

/// Free fall from the start pose, through everything, with tens of kJ and a wrist that whips
/// around: what energy RK4 loses or gains vanishes with at least the fourth power of the step, so
/// the equations themselves conserve it.
#[test]
fn energy_error_of_a_violent_fall_is_truncation_only() {
    let zeta = Machine::reference().start.zeta;
    let (coarse, kinetic) = unforced(zeta, [0.0; DOF], 5e-4, 2000);
    let (fine, _) = unforced(zeta, [0.0; DOF], 2.5e-4, 4000);
    assert!(kinetic > 1e4, "the machine must fall: {kinetic} J");
    assert!(fine < coarse / 14.0, "{coarse:e} J, {fine:e} J");
}

/// d(T + U)/dt = power of drives, friction, stops and environment: the derivative outputs against
/// forces times rates. Rounding only: 1e-12 of the summed powers.
#[test]
fn power_balances() {
    let (machine, hdrm) = plant();
    let mut random = Random(0x1234_5678_9ABC_DEF1);
    for _ in 0..300 {
        let (state, input) = (random.state(&machine), random.input());
        let rates = hdrm.output_derivative(&state, &input, &Input::default());
        let out = hdrm.output(&state, &input);
        let drives: f64 = (0..3)
            .map(|i| input.f[i] * out.x_dot[i] + input.tau_wrist[i] * state.zeta_dot[3 + i])
            .sum();
        let friction: f64 = (0..DOF)
            .map(|i| -machine.joint_viscous[i] * state.zeta_dot[i].powi(2))
            .sum();
        // W_env acts in T4 axes; turn it to the world where tip_velocity is given.
        let [w, i, j, k] = out.tip_orientation;
        let q = nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, i, j, k));
        let world = |v: &[f64]| q * nalgebra::Vector3::from_column_slice(v);
        let (f, m) = (world(&input.wrench_env[..3]), world(&input.wrench_env[3..]));
        let V = Vector6::from(out.tip_velocity);
        let environment = V.fixed_rows::<3>(0).dot(&f) + V.fixed_rows::<3>(3).dot(&m);
        let power = drives + friction + environment;
        let scale =
            drives.abs() + friction.abs() + environment.abs() + rates.energy_potential.abs();
        let residual = rates.energy_kinetic + rates.energy_potential - power;
        assert!(
            residual.abs() < 1e-12 * scale,
            "{residual:e} W of {scale:e} W at {state:?}"
        );

        // The same kinetic power from M and its bias: ζ̇ᵀ(M ζ̈) + ½ζ̇ᵀṀζ̇, Ṁ by difference.
        let h = 1e-5;
        let M = |s: f64| hdrm.equations_of_motion(&moved(&state, &[0.0; DOF], s)).0;
        let M_dot: Matrix6<f64> = (M(h) - M(-h)) / (2.0 * h);
        let w = Vector6::from(state.zeta_dot);
        let kinetic = w.dot(&(M(0.0) * Vector6::from(out.zeta_ddot))) + 0.5 * w.dot(&(M_dot * w));
        // Central differences: ε·|M|/h ≈ 1e-7 on some 1e4 W.
        let error = kinetic - rates.energy_kinetic;
        assert!(
            error.abs() < 1e-8 * scale,
            "{error:e} W of {scale:e} W at {state:?}"
        );
    }
}

/// ζ̇ᵀ(½Ṁζ̇ − C ζ̇) = 0: the Coriolis part `h(ζ, ζ̇) − h(ζ, 0)` does as much work as ½Ṁ.
#[test]
fn coriolis_forces_do_no_work_beyond_the_change_of_inertia() {
    let (machine, hdrm) = plant();
    let mut random = Random(0x0BAD_CAFE_DEAD_BEEF);
    for _ in 0..100 {
        let state = random.state(&machine);
        let still = State {
            zeta_dot: [0.0; DOF],
            ..state
        };
        let w = Vector6::from(state.zeta_dot);
        let coriolis = hdrm.equations_of_motion(&state).1 - hdrm.equations_of_motion(&still).1;
        let h = 1e-5;
        let M = |s: f64| hdrm.equations_of_motion(&moved(&state, &[0.0; DOF], s)).0;
        let M_dot = (M(h) - M(-h)) / (2.0 * h);
        let work = w.dot(&coriolis) - 0.5 * w.dot(&(M_dot * w));
        let scale = w.norm() * coriolis.norm();
        // Central differences of M, entries to 1e4: truncation and rounding below 1e-6.
        assert!(
            work.abs() < 1e-8 * (scale + 1e3),
            "{work:e} of {scale:e} at {state:?}"
        );
    }
}

#[test]
fn inverse_of_forward_is_identity() {
    let (machine, hdrm) = plant();
    let mut random = Random(0x7777_1234_ABCD_0001);
    for _ in 0..1000 {
        let (state, input) = (random.state(&machine), random.input());
        let zeta_ddot = hdrm.forward_dynamics(&state, &input);
        let (f, tau) = hdrm.inverse_dynamics(&state, &zeta_ddot, &input.wrench_env);
        for i in 0..3 {
            // Forces to 1e5 N, κ(M)·ε ≈ 1e-12.
            let (df, dtau) = (f[i] - input.f[i], tau[i] - input.tau_wrist[i]);
            assert!(
                df.abs() < 1e-6 && dtau.abs() < 1e-8,
                "{df:e} {dtau:e} at {state:?}"
            );
        }
    }
}

/// The derivative outputs against central differences of the outputs along the true motion,
/// including the rate of the accelerations, within free range and inside a stop.
#[test]
fn output_derivatives_are_exact() {
    let (machine, hdrm) = plant();
    let mut random = Random(0x5555_AAAA_1111_2222);
    for k in 0..200 {
        let (mut state, input, input_dot) =
            (random.state(&machine), random.input(), random.input());
        let in_contact = k % 2 == 0;
        if in_contact {
            // Into the lower wrist stop and the upper stroke stop, moving further in.
            state.zeta[4] = machine.limits.zeta()[4][0] - 1e-3;
            state.zeta[2] = machine.limits.zeta()[2][1] + 1e-3;
            state.zeta_dot[4] = -state.zeta_dot[4].abs();
            state.zeta_dot[2] = state.zeta_dot[2].abs();
        }
        let a = hdrm.forward_dynamics(&state, &input);
        // Sideways by the exact state derivative; second order is enough for a central difference.
        let h = if in_contact { 1e-6 } else { 3e-6 };
        let at = |s: f64| {
            let u = Input {
                f: std::array::from_fn(|i| input.f[i] + s * input_dot.f[i]),
                tau_wrist: std::array::from_fn(|i| input.tau_wrist[i] + s * input_dot.tau_wrist[i]),
                wrench_env: std::array::from_fn(|i| {
                    input.wrench_env[i] + s * input_dot.wrench_env[i]
                }),
                ..Input::default()
            };
            hdrm.output(&moved(&state, &a, s), &u)
        };
        let exact = hdrm.output_derivative(&state, &input, &input_dot);
        let blocks = flat(&at(-h))
            .into_iter()
            .zip(flat(&at(h)))
            .zip(flat(&exact));
        for (n, ((low, high), exact)) in blocks.enumerate() {
            let numeric = (&high - &low) / (2.0 * h);
            // Truncation (hλ)²/6: 2e-8 at λ = 100 1/s in free range, 2e-7 at 1e3 1/s in contact.
            // Rounding: ε/h = 1e-10 of the block's size, times up to κ(M) for the accelerations.
            let error = (&numeric - &exact).norm();
            let relative = if in_contact { 1e-6 } else { 1e-7 };
            let tolerance = relative * (high.norm() + exact.norm()) + 1e-9;
            assert!(
                error < tolerance,
                "block {n}: {numeric} vs {exact} at {state:?}"
            );
        }
    }
}

/// The outputs in blocks of one kind each.
fn flat(out: &Output) -> Vec<DVector<f64>> {
    [
        &out.x[..],
        &out.x_dot,
        &out.zeta,
        &out.zeta_dot,
        &out.zeta_ddot,
        &out.f_hold,
        &out.tau_hold,
        &out.tip_position,
        &out.tip_orientation,
        &out.tip_velocity,
        &[out.energy_kinetic],
        &[out.energy_potential],
    ]
    .map(DVector::from_column_slice)
    .to_vec()
}

/// Accelerations are linear in the forces, so a finite difference of any size is exact; a wrist
/// drive in saturation does not follow.
#[test]
fn directional_derivatives_are_exact() {
    let (machine, hdrm) = plant();
    let mut random = Random(0x0F0F_1357_2468_ACE1);
    for _ in 0..200 {
        let (state, mut input, seed) = (random.state(&machine), random.input(), random.input());
        input.tau_wrist[1] = 9000.0;
        let mut more = input;
        for i in 0..3 {
            more.f[i] += seed.f[i];
            more.wrench_env[i] += seed.wrench_env[i];
            more.wrench_env[3 + i] += seed.wrench_env[3 + i];
        }
        more.tau_wrist[0] += 0.01 * seed.tau_wrist[0];
        more.tau_wrist[1] += seed.tau_wrist[1];
        let mut seed = seed;
        seed.tau_wrist[0] *= 0.01;
        seed.tau_wrist[2] = 0.0;
        let exact = hdrm.directional_derivative(&state, &input, &seed).zeta_ddot;
        let (a, b) = (
            hdrm.forward_dynamics(&state, &input),
            hdrm.forward_dynamics(&state, &more),
        );
        for i in 0..DOF {
            let error = (b[i] - a[i] - exact[i]).abs();
            assert!(
                error < 1e-10 * (a[i].abs() + b[i].abs() + 1.0),
                "{error:e} at {state:?}"
            );
        }
    }
}

/// Halving the substep divides the error by 16. Below the largest substep the step itself is the
/// substep.
#[test]
fn the_step_is_of_fourth_order() {
    let (machine, hdrm) = plant();
    let start = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.3, -0.2, 0.4, 2.1, -1.7, 2.9],
        ..State::default()
    };
    // Strongly varying forces, so that truncation stands out of rounding.
    let input = |t: f64| Input {
        f: [30e3, 41e3, 32e3].map(|f| f * (1.0 + (700.0 * t).sin())),
        tau_wrist: [500.0, 300.0, 700.0].map(|tau| tau * (900.0 * t).cos()),
        wrench_env: [0.0; 6],
        ..Input::default()
    };
    let end = |n: u32| {
        let h = 0.016 / f64::from(n);
        (0..n).fold(start, |state, k| {
            let t = f64::from(k) * h;
            hdrm.step(&state, |s| input(t + s), t, h).expect("finite")
        })
    };
    let exact = Vector6::from(end(512).zeta_dot);
    let error = |n: u32| (Vector6::from(end(n).zeta_dot) - exact).norm();
    let (coarse, fine) = (error(16), error(32));
    let order = (coarse / fine).log2();
    assert!(
        (order - 4.0).abs() < 0.15,
        "order {order}: {coarse:e}, {fine:e}"
    );
}

/// One long step is the same as its substeps one by one, to the bit.
#[test]
fn a_long_step_is_its_substeps() {
    let (machine, hdrm) = plant();
    let start = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.0; DOF],
        ..State::default()
    };
    let input = Input {
        f: [1000.0, 40e3, 30e3],
        ..Input::default()
    };
    let long = hdrm
        .step(&start, |_| input, 0.0, 4.0 / 1024.0)
        .expect("finite");
    let short = (0..4).fold(start, |state, _| {
        hdrm.step(&state, |_| input, 0.0, 1.0 / 1024.0)
            .expect("finite")
    });
    assert_eq!(long, short);
}

/// Masters take h as a difference of times, (t + h) − t, and some round their clock to nanoseconds:
/// neither adds a substep.
#[test]
fn rounding_of_the_step_adds_no_substep() {
    let (machine, hdrm) = plant();
    let start = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.0; DOF],
        ..State::default()
    };
    let evaluations = |h: f64| {
        let count = std::cell::Cell::new(0);
        let input = |_| {
            count.set(count.get() + 1);
            Input::default()
        };
        hdrm.step(&start, input, 0.0, h).expect("finite");
        count.get()
    };
    let rounded = (0..1000).map(|k| f64::from(k) * 1e-3);
    let steps: Vec<f64> = rounded.map(|t| (t + 1e-3) - t).collect();
    assert!(steps.iter().any(|&h| h > 1e-3));
    for h in steps {
        assert_eq!(evaluations(h), evaluations(1e-3), "h = {h:e}");
    }
    assert_eq!(evaluations(1e-3 + 1e-9), evaluations(1e-3));
    assert_eq!(evaluations(1.0005e-3), evaluations(1e-3));
    // Each step asks once more, for the brakes.
    assert_eq!(evaluations(1.002e-3) - 1, 2 * (evaluations(1e-3) - 1));
}

#[test]
fn a_step_that_fails_says_why() {
    let (machine, hdrm) = plant();
    let state = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.0; DOF],
        ..State::default()
    };
    for h in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let error = hdrm
            .step(&state, |_| Input::default(), 1.5, h)
            .expect_err("bad step");
        assert!(
            error.to_string().starts_with("t = 1.5 s: step h = "),
            "{error}"
        );
    }
    let endless = Input {
        f: [0.0, f64::MAX, 0.0],
        ..Input::default()
    };
    let error = hdrm
        .step(&state, |_| endless, 0.0, 1e-3)
        .expect_err("not finite");
    assert!(error.to_string().contains("zeta"), "{error}");
}

/// An independent prototype holds the start pose with f = [0, 41143, 32179] N and
/// tau = [−90.2, 147.2, 0] N·m (printed digits).
#[test]
fn start_equilibrium() {
    let machine = Machine::reference();
    let hdrm = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid reference");
    let (f, tau) = hdrm.holding(&machine.start.zeta);
    for (value, expected, digit) in [
        (f[0], 0.0, 1e-9),
        (f[1], 41143.0, 0.5),
        (f[2], 32179.0, 0.5),
        (tau[0], -90.2, 0.051),
        (tau[1], 147.2, 0.051),
        (tau[2], 0.0, 0.05),
    ] {
        assert!((value - expected).abs() <= digit, "{value} vs {expected}");
    }
}

#[test]
fn bad_options_are_named() {
    let machine = Machine::reference();
    let good = Options::from_machine(&machine);
    let refused = |options: Options| {
        Hdrm::new(&machine, &options)
            .expect_err("must be refused")
            .to_string()
    };
    let text = refused(Options {
        inertia_scale: 0.0,
        ..good
    });
    assert!(text.contains("inertia_scale"), "{text}");
    let text = refused(Options {
        load: Load {
            payload_mass: f64::NAN,
            ..good.load
        },
        ..good
    });
    assert!(text.contains("payload.mass"), "{text}");
    let mut geometry = machine.clone();
    geometry.geometry.d4 = 0.05;
    let text = Hdrm::new(&geometry, &good)
        .expect_err("open loop")
        .to_string();
    assert!(text.contains("four-bar"), "{text}");
}
