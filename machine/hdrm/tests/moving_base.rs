//! A base that moves: against an independent Lagrangian whose base pose is a function of time
//! (`tests/oracle/moving_base.py`, JAX), and by the balance of energy in an inertial frame.
use hdrm::{BODIES, Hdrm, Input, Load, Options, State};
use machine_file::Machine;
use nalgebra::{DVector, Vector3};
use serde::Deserialize;
use spatial::Twist;
use std::path::Path;

#[derive(Deserialize)]
struct Golden {
    plants: Vec<Plant>,
}

#[derive(Deserialize)]
struct Plant {
    machine: Machine,
    inertia_scale: f64,
    payload_mass: f64,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    zeta: [f64; 6],
    zeta_dot: [f64; 6],
    f: [f64; 3],
    tau: [f64; 3],
    W_env: [f64; 6],
    tilt: [f64; 2],
    acceleration: [f64; 3],
    angular_velocity: [f64; 3],
    angular_acceleration: [f64; 3],
    zeta_ddot: [f64; 6],
    base_wrench: [f64; 6],
}

fn plant(machine: &Machine, inertia_scale: f64, payload_mass: f64) -> Hdrm {
    let options = Options {
        inertia_scale,
        load: Load {
            payload_mass,
            ..Load::from_machine(machine)
        },
        ..Options::from_machine(machine)
    };
    Hdrm::new(machine, &options).expect("working machine")
}

fn relative_error(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (DVector::from_column_slice(a), DVector::from_column_slice(b));
    (a - &b).norm() / b.norm()
}

/// Tolerance 1e-10 relative: rounding gives some κ(M)·ε with κ ≈ 1e4, that is 1e-12; the turning
/// that is left out changes accelerations by a hundredth at least.
#[test]
fn accelerations_and_the_bases_wrench_equal_the_lagrangian() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/oracle/moving_base.json");
    let text = std::fs::read_to_string(&path).expect("golden file");
    let golden: Golden = serde_json::from_str(&text).expect("golden format");
    let (mut worst, mut least, mut count) = ([0.0_f64; 2], f64::INFINITY, 0);
    for of in golden.plants {
        let hdrm = plant(&of.machine, of.inertia_scale, of.payload_mass);
        for case in of.cases {
            let state = State {
                zeta: case.zeta,
                zeta_dot: case.zeta_dot,
                ..State::default()
            };
            let input = Input {
                f: case.f,
                tau_wrist: case.tau,
                wrench_env: case.W_env,
                base_acceleration: case.acceleration,
                base_tilt: case.tilt,
                base_angular_velocity: case.angular_velocity,
                base_angular_acceleration: case.angular_acceleration,
                ..Input::default()
            };
            let zeta_ddot = hdrm.forward_dynamics(&state, &input);
            let wrench = hdrm.base_wrench(&state, &input);
            let errors = [
                relative_error(&zeta_ddot, &case.zeta_ddot),
                relative_error(&wrench, &case.base_wrench),
            ];
            worst = std::array::from_fn(|i| worst[i].max(errors[i]));
            assert!(errors.iter().all(|e| *e < 1e-10), "{errors:?} at {input:?}");
            let still = Input {
                base_angular_velocity: [0.0; 3],
                base_angular_acceleration: [0.0; 3],
                ..input
            };
            let without = hdrm.forward_dynamics(&state, &still);
            least = least.min(relative_error(&without, &case.zeta_ddot));
            count += 1;
        }
    }
    println!("{count} states: {worst:?}; without the turning at least {least:e}");
    assert!(count >= 50 && least > 1e-4);
}

/// A ship's base about its fixed origin: roll, pitch and yaw as sines; what the machine gets of it
/// at the time t.
fn ship(t: f64) -> Input {
    // Angle, rate and acceleration.
    let swing = |size: f64, w: f64| {
        let (sin, cos) = (w * t).sin_cos();
        [size * sin, size * w * cos, -size * w * w * sin]
    };
    let ([r, r1, r2], [p, p1, p2]) = (swing(0.2, 1.1), swing(0.15, 1.7));
    // Ω = Rz(p)ᵀ·x·r' + z·p' and its derivative.
    let (s, c) = p.sin_cos();
    Input {
        f: [1500.0 * (2.0 * t).sin(), 41e3, 32e3],
        tau_wrist: [-90.0, 150.0, 0.0],
        base_tilt: [r, p],
        base_angular_velocity: [c * r1, -s * r1, p1],
        base_angular_acceleration: [c * r2 - s * p1 * r1, -s * r2 - c * p1 * r1, p2],
        ..Input::default()
    }
}

/// Kinetic energy in the inertial frame: each body's own twist, the base's included.
fn kinetic(plant: &Hdrm, state: &State, input: &Input) -> f64 {
    let configuration = plant.tree().configuration(&state.zeta);
    let ground = Twist::new(Vector3::zeros(), input.base_angular_velocity.into());
    let mut twists = [Twist::new(Vector3::zeros(), Vector3::zeros()); 13];
    let mut sum = 0.0;
    for body in BODIES {
        let parent = body.parent().map_or(ground, |p| twists[p as usize]);
        let link = configuration.link(body);
        let rate = link.gear * state.zeta_dot[body.coordinate()];
        let V = link.pose.twist_to_B(&parent) + body.axis() * rate;
        sum += 0.5 * V.power(&plant.inertias()[body as usize].apply(&V));
        twists[body as usize] = V;
    }
    sum
}

/// Kinetic and potential energy change by the work of drives, friction and of the base's moment
/// along its turning, all as an observer on the ground sees it. Both the steps (RK4 of half a
/// millisecond) and the integral of the power (Simpson) err by some 1e-9 of what is turned over.
#[test]
fn energy_balances_with_the_wrench_of_the_base() {
    let machine = Machine::reference();
    let plant = plant(&machine, 1.0, 300.0);
    let mut state = State {
        zeta: machine.start.zeta,
        ..State::default()
    };
    let energy = |state: &State, t: f64| {
        let input = ship(t);
        kinetic(&plant, state, &input) + plant.output(state, &input).energy_potential
    };
    // Of drives and friction, and of the base.
    let power = |state: &State, t: f64| {
        let input = ship(t);
        let y = plant.output(state, &input);
        let rods: f64 = (0..3).map(|i| input.f[i] * y.x_dot[i]).sum();
        let joints: f64 = (0..6)
            .map(|i| {
                let w = state.zeta_dot[i];
                let torque = if i < 3 { 0.0 } else { input.tau_wrist[i - 3] };
                w * (torque - machine.joint_viscous[i] * w)
            })
            .sum();
        let wrench = plant.base_wrench(state, &input);
        let turn: f64 = (0..3)
            .map(|i| wrench[3 + i] * input.base_angular_velocity[i])
            .sum();
        [rods + joints, turn]
    };
    let (h, mut work, mut turned) = (1e-3, [0.0; 2], 0.0);
    let start = energy(&state, 0.0);
    for k in 0..700 {
        let t = f64::from(k) * h;
        let half = |state: &State, t: f64| {
            plant
                .step(state, |s| ship(t + s), t, 0.5 * h)
                .expect("finite")
        };
        let middle = half(&state, t);
        let next = half(&middle, t + 0.5 * h);
        let [a, b, c] = [
            power(&state, t),
            power(&middle, t + 0.5 * h),
            power(&next, t + h),
        ];
        for i in 0..2 {
            work[i] += h / 6.0 * (a[i] + 4.0 * b[i] + c[i]);
        }
        turned += h * (a[0].abs() + a[1].abs());
        state = next;
    }
    let gained = energy(&state, 0.7) - start;
    let error = gained - work[0] - work[1];
    println!(
        "gained {gained} J, of drives {} J, of the base {} J, error {error:e} J of {turned} J",
        work[0], work[1]
    );
    assert!(error.abs() < 1e-10 * turned, "{error:e} J of {turned} J");
    assert!(work[1].abs() > 0.01 * turned);
}

/// The derivative of the outputs along the motion, and of the accelerations by the inputs, against
/// differences: central ones over ±1e-6 s err by 1e-12/6 of the third derivative and by rounding of
/// 1e-10 of the value; the forces are quadratic in the inputs of the base, so there only rounding
/// counts.
#[test]
fn derivatives_know_the_bases_turning() {
    let machine = Machine::reference();
    let plant = plant(&machine, 1.1, 330.0);
    let state = State {
        zeta: [0.31, 0.52, -1.13, 0.41, -0.62, 0.37],
        zeta_dot: [0.11, -0.07, 0.13, 0.3, -0.2, 0.4],
        ..State::default()
    };
    let input = Input {
        base_acceleration: [0.3, -0.2, 0.5],
        ..ship(0.7)
    };
    let input_dot = Input {
        base_angular_velocity: [0.3, -0.7, 0.2],
        base_angular_acceleration: [-1.1, 0.4, 0.9],
        base_tilt: [0.2, -0.1],
        ..Input::default()
    };
    let moved = |s: f64| {
        let step = |x: f64, v: f64| x + s * v;
        let zip = |x: [f64; 3], v: [f64; 3]| std::array::from_fn(|i| step(x[i], v[i]));
        Input {
            base_angular_velocity: zip(
                input.base_angular_velocity,
                input_dot.base_angular_velocity,
            ),
            base_angular_acceleration: zip(
                input.base_angular_acceleration,
                input_dot.base_angular_acceleration,
            ),
            base_tilt: std::array::from_fn(|i| step(input.base_tilt[i], input_dot.base_tilt[i])),
            ..input
        }
    };
    let near = |found: f64, expected: f64, bound: f64, what: &str| {
        assert!(
            (found - expected).abs() < bound * (1.0 + expected.abs()),
            "{what}: {found} {expected}"
        );
    };

    let rate = plant.output_derivative(&state, &input, &input_dot);
    let d = 1e-6;
    let after = |s: f64| {
        let a = plant.forward_dynamics(&state, &input);
        let zeta =
            std::array::from_fn(|i| state.zeta[i] + s * (state.zeta_dot[i] + 0.5 * s * a[i]));
        let zeta_dot = std::array::from_fn(|i| state.zeta_dot[i] + s * a[i]);
        plant.output(
            &State {
                zeta,
                zeta_dot,
                ..state
            },
            &moved(s),
        )
    };
    let (before, after) = (after(-d), after(d));
    for i in 0..6 {
        let slope = (after.zeta_ddot[i] - before.zeta_ddot[i]) / (2.0 * d);
        near(rate.zeta_ddot[i], slope, 1e-6, "zeta_ddot");
    }
    let slope = (after.energy_kinetic - before.energy_kinetic) / (2.0 * d);
    near(rate.energy_kinetic, slope, 1e-6, "kinetic energy");

    let seed = Input {
        base_tilt: [0.0; 2],
        ..input_dot
    };
    let change = plant.directional_derivative(&state, &input, &seed);
    let at = |s: f64| {
        let u = moved(s);
        plant.forward_dynamics(
            &state,
            &Input {
                base_tilt: input.base_tilt,
                ..u
            },
        )
    };
    let (less, more) = (at(-0.5), at(0.5));
    for i in 0..6 {
        near(change.zeta_ddot[i], more[i] - less[i], 1e-10, "directional");
    }

    // A tilt turns gravity, which the holding forces feel too; over ±1e-4 rad central differences
    // err by 1e-8/6.
    let tilting = Input {
        base_tilt: input_dot.base_tilt,
        ..Input::default()
    };
    let change = plant.directional_derivative(&state, &input, &tilting);
    let d = 1e-4 / 0.2;
    let [less, more] = [-d, d].map(|s| {
        let base_tilt = moved(s).base_tilt;
        plant.output(&state, &Input { base_tilt, ..input })
    });
    for i in 0..3 {
        let slope = |of: fn(&hdrm::Output) -> [f64; 3]| (of(&more)[i] - of(&less)[i]) / (2.0 * d);
        near(change.f_hold[i], slope(|y| y.f_hold), 1e-7, "f_hold");
        near(change.tau_hold[i], slope(|y| y.tau_hold), 1e-7, "tau_hold");
    }
}
