//! Tests that need the whole controller and access to its private state.

use super::*;
use crate::{Mode, RateLimits, tip_pose};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Integral after `seconds` in steps of 1 ms beside the start pose, by 1e-4 rad in each joint.
fn after(machine: &Machine, mode: Mode, integral: bool, seconds: f64) -> (Vector6<f64>, Errors) {
    let settings = Settings {
        mode,
        integral,
        ..Settings::from_gains(&machine.controller)
    };
    let start = Input {
        zeta: machine.start.zeta,
        ..Input::default()
    };
    let network = Surrogate::reference();
    let mut controller =
        Controller::new(machine, &network, Trajectory::Cubic, &settings, &start, 0.0)
            .expect("valid");
    let beside = Input {
        zeta: start.zeta.map(|zeta| zeta + 1e-4),
        ..start
    };
    let now = controller.evaluate(&settings, &beside).expect("finite");
    for k in 0..(seconds / 1e-3) as u32 {
        let now = controller.evaluate(&settings, &beside).expect("finite");
        let t = f64::from(k) * 1e-3;
        controller
            .step(&now, &settings, &beside, t, 1e-3)
            .expect("finite");
    }
    (controller.state.integral, now.errors)
}

/// Closed form: the error stands still, so `z = ω e t`. Tolerance: one rounding a step.
#[test]
fn the_integral_grows_with_the_error_in_the_modes_that_have_one() {
    let machine = Machine::reference();
    let (z, errors) = after(&machine, Mode::Pd, true, 0.05);
    let expected = errors.e * (machine.controller.omega_tip * 0.05);
    assert!(expected.norm() > 1e-5, "{expected}");
    assert!((z - expected).norm() < 50.0 * f64::EPSILON * expected.norm());
    assert_eq!(after(&machine, Mode::Pd, false, 0.05).0, Vector6::zeros());
}

#[test]
fn the_integral_rests_at_each_limit() {
    let nominal = Machine::reference();
    let mut machines = [nominal.clone(), nominal.clone(), nominal];
    machines[0].emla.lift.v_max = 1.0;
    machines[1].emla.lift.i_max = 1.0;
    machines[2].limits.tau_wrist_max[1] = 1.0;
    for machine in machines {
        let (z, _) = after(&machine, Mode::PdGravity, true, 0.05);
        assert_eq!(z, Vector6::zeros());
    }
}

/// Integral, and what was learnt of the payload's mass, kg, after 50 ms beside the start pose by
/// `off`, rad, in the lift joint, where the lift rod may have the share `limit` of the force that
/// holds the machine there; the required force of that rod, N, and its limit.
fn limited(off: f64, limit: f64) -> (Vector6<f64>, f64, [f64; 2], Errors) {
    let mut machine = Machine::reference();
    let start = Input {
        zeta: machine.start.zeta,
        ..Input::default()
    };
    let network = Surrogate::reference();
    let path = Trajectory::Cubic;
    let new = |machine: &Machine, settings: &Settings| {
        Controller::new(machine, &network, path, settings, &start, 0.0).expect("valid")
    };
    let settings = Settings {
        integral: true,
        force_limit: 1.25,
        ..Settings::from_gains(&machine.controller)
    };
    let holding = new(&machine, &settings).evaluate(&settings, &start);
    machine.ratings.lift.force_max = limit * holding.expect("finite").output.f_required[1];
    let most = settings.force_limit * machine.ratings.lift.force_max;
    let mut controller = new(&machine, &settings);
    let mut beside = start;
    beside.zeta[1] += off;
    let mass = |controller: &Controller| {
        let estimate = &controller.state.bodies.estimates[hdrm::Body::PL as usize];
        estimate.inertia().m
    };
    let before = mass(&controller);
    let now = controller.evaluate(&settings, &beside).expect("finite");
    for k in 0..50 {
        let now = controller.evaluate(&settings, &beside).expect("finite");
        let t = f64::from(k) * 1e-3;
        controller
            .step(&now, &settings, &beside, t, 1e-3)
            .expect("finite");
    }
    let learnt = mass(&controller) - before;
    let force = [now.output.f_required[1], most];
    (controller.state.integral, learnt, force, now.errors)
}

/// At the limit of its force a rod that is asked for more, where the machine is too low, has the
/// limit exactly; the integral rests and nothing is learnt. Where the machine is too high the
/// integral leads back from the limit, and grows in closed form as within it; nothing is learnt
/// there either.
#[test]
fn at_the_limit_of_a_force_the_integral_only_goes_back_and_nothing_is_learnt() {
    let (z, learnt, [force, most], _) = limited(-1e-4, 0.7);
    assert_eq!((z, learnt, force), (Vector6::zeros(), 0.0, most));
    for (limit, is_limited) in [(0.7, true), (2.0, false)] {
        let (z, learnt, [force, most], errors) = limited(1e-4, limit);
        let expected = errors.e * (Machine::reference().controller.omega_tip * 0.05);
        assert!(expected.norm() > 1e-6, "{expected}");
        assert!((z - expected).norm() < 50.0 * f64::EPSILON * expected.norm());
        assert_eq!((force == most, learnt == 0.0), (is_limited, is_limited));
    }
}

/// Wrist torques beside the start pose, by 1e-4 rad in each joint, and what the law has integrated
/// after 20 ms there.
fn beside(mode: Mode, change: impl Fn(&mut Gains)) -> ([f64; 3], [f64; DOF]) {
    let machine = Machine::reference();
    let mut settings = Settings {
        mode,
        ..Settings::from_gains(&machine.controller)
    };
    change(&mut settings.gains);
    let start = Input {
        zeta: machine.start.zeta,
        ..Input::default()
    };
    let network = Surrogate::reference();
    let mut controller = Controller::new(
        &machine,
        &network,
        Trajectory::Cubic,
        &settings,
        &start,
        0.0,
    )
    .expect("valid");
    let beside = Input {
        zeta: start.zeta.map(|zeta| zeta + 1e-4),
        ..start
    };
    let first = controller.evaluate(&settings, &beside).expect("finite");
    for k in 0..20 {
        let now = controller.evaluate(&settings, &beside).expect("finite");
        let t = f64::from(k) * 1e-3;
        controller
            .step(&now, &settings, &beside, t, 1e-3)
            .expect("finite");
    }
    (first.output.tau_wrist, controller.state.law_integral)
}

/// Closed forms with the error standing still. Two gains of the modular law tell `M s`, since its
/// torque is `model + κ M s`. Then the observer asks for `(κ + ω) M s` and integrates `ω κ M s`;
/// super-twisting asks for `κ M s r` and integrates `ω κ M s r²` with `r² = s_0/|s|`. The cascade
/// asks for `K s` and integrates `ω K s`. The laws before them integrate nothing. Tolerance:
/// rounding of differences of torques of 1 kN·m, and of 20 sums.
#[test]
fn the_rivals_integrate_what_they_ask_for() {
    let (kappa, omega) = (30.0, 2.5);
    let set = |gains: &mut Gains| (gains.kappa_KA, gains.omega_tip) = (kappa, omega);
    let (once, nothing) = beside(Mode::Modular, set);
    let (twice, _) = beside(Mode::Modular, |gains| gains.kappa_KA = 2.0 * kappa);
    assert_eq!(nothing, [0.0; DOF]);
    let (observed, by_observer) = beside(Mode::DisturbanceObserver, set);
    let (sliding, by_sliding) = beside(Mode::SuperTwisting, set);
    let (cascade, by_cascade) = beside(Mode::Cascade, set);
    let (damped, _) = beside(Mode::Cascade, |gains| {
        set(gains);
        gains.pd_wrist_damping = gains.pd_wrist_damping.map(|d| 2.0 * d);
    });
    let near = |found: f64, expected: f64, what: &str| {
        let tolerance = 1e-9 + 1e-6 * expected.abs();
        assert!(
            (found - expected).abs() < tolerance,
            "{what}: {found}, {expected}"
        );
    };
    let mut largest = 0.0_f64;
    for j in 0..3 {
        let momentum = (twice[j] - once[j]) / kappa;
        largest = largest.max(momentum.abs());
        near(observed[j] - once[j], omega * momentum, "observer");
        near(
            by_observer[3 + j],
            0.02 * omega * kappa * momentum,
            "its integral",
        );
        let root = 1.0 + (sliding[j] - once[j]) / (kappa * momentum);
        assert!(root > 1.0 && root < 4.1, "{root}");
        near(
            by_sliding[3 + j],
            0.02 * omega * kappa * momentum * root * root,
            "super-twisting",
        );
        near(
            by_cascade[3 + j],
            0.02 * omega * (damped[j] - cascade[j]),
            "cascade",
        );
    }
    assert!(largest > 1e-3, "{largest}");
}

/// Joints, and the reference of the tip, on smooth ways; the orientations meet at t = 0, where the
/// law's derivative is exact.
fn at(machine: &Machine, t: f64) -> Input {
    let wave = |i: usize| (0.9 + 0.2 * i as f64, 0.4 * i as f64, 0.05 + 0.01 * i as f64);
    let zeta = |i: usize| {
        let (w, phase, size) = wave(i);
        machine.start.zeta[i] + size * ((w * t + phase).sin() - phase.sin())
    };
    let rate = |i: usize| {
        let (w, phase, size) = wave(i);
        size * w * (w * t + phase).cos()
    };
    let (position, [w, x, y, z]) = tip_pose(machine, &machine.start.zeta).expect("works");
    let (v, a) = ([0.11, -0.06, 0.08], [-0.3, 0.2, 0.4]);
    let turning = Vector3::new(0.2, -0.1, 0.15);
    let q =
        UnitQuaternion::from_scaled_axis(turning * t).into_inner() * Quaternion::new(w, x, y, z);
    Input {
        zeta: std::array::from_fn(zeta),
        zeta_dot: std::array::from_fn(rate),
        reference_position: std::array::from_fn(|k| {
            position[k] + 0.01 + t * (v[k] + 0.5 * t * a[k])
        }),
        reference_velocity: std::array::from_fn(|k| v[k] + t * a[k]),
        reference_acceleration: a,
        reference_orientation: [q.w, q.i, q.j, q.k],
        reference_angular_velocity: turning.into(),
        ..Input::default()
    }
}

/// The required accelerations of rods and joints are the rates of the required velocities, with
/// reference and machine in motion: central differences over 0.1 ms, which err by 1e-9 of the third
/// derivatives and ε/δ.
#[test]
fn required_accelerations_are_rates_of_the_required_velocities() {
    let machine = Machine::reference();
    let mut settings = Settings {
        mode: Mode::Modular,
        ..Settings::from_gains(&machine.controller)
    };
    (
        settings.gains.Lambda_position,
        settings.gains.Lambda_orientation,
    ) = (4.0, 3.0);
    let network = Surrogate::reference();
    let controller = Controller::new(
        &machine,
        &network,
        Trajectory::External,
        &settings,
        &at(&machine, 0.0),
        0.0,
    )
    .expect("works");
    let of = |t: f64| {
        let now = controller.evaluate(&settings, &at(&machine, t));
        now.expect("finite").demands
    };
    let d = 1e-4;
    let [before, now, after] = [-d, 0.0, d].map(of);
    for i in 0..3 {
        let rate = (after[i].motion.x_r_dot - before[i].motion.x_r_dot) / (2.0 * d);
        let error = (now[i].motion.x_r_ddot - rate).abs();
        assert!(rate.abs() > 0.05, "{rate}");
        assert!(
            error < 1e-6 * rate.abs().max(1.0),
            "rod {}: {rate} m/s², off by {error:e}",
            i + 1
        );
    }
}

/// A step that is refused at a sample inside it leaves the controller as it was: what it tells of
/// the reference, and where the same commands lead it afterwards.
#[test]
fn a_refused_step_leaves_commanded_rates_as_they_were() {
    let machine = Machine::reference();
    let settings = Settings::from_gains(&machine.controller);
    let network = Surrogate::reference();
    let sane = Input {
        zeta: machine.start.zeta,
        rate_joint: [0.1, -0.05, 0.05, 0.2, -0.2, 0.3],
        ..Input::default()
    };
    let absurd = Input {
        zeta_dot: [1e200; DOF],
        ..sane
    };
    let rates = Trajectory::Rates(RateLimits::default());
    let mut controller = Controller::new(&machine, &network, rates, &settings, &sane, 0.0)
        .expect("works")
        .with_timing(Timing {
            sample_time: 1e-3,
            delay: 0,
        });
    let reference = |controller: &Controller| {
        let now = controller.evaluate(&settings, &sane).expect("finite");
        let y = now.output(&[0.0; 3]);
        (y.desired_position, y.desired_orientation)
    };
    let step = |controller: &mut Controller, input: &Input, t: f64| {
        let now = controller.evaluate(&settings, &sane).expect("finite");
        controller.step(&now, &settings, input, t, 0.1)
    };
    step(&mut controller, &sane, 0.0).expect("finite");
    let mut spared = controller.clone();
    let before = reference(&controller);
    assert!(step(&mut controller, &absurd, 0.1).is_err());
    assert_eq!(reference(&controller), before);
    for other in [&mut controller, &mut spared] {
        step(other, &sane, 0.1).expect("finite");
    }
    assert_eq!(reference(&controller), reference(&spared));
    assert_ne!(reference(&controller), before, "the reference moves");
}

/// As the gains fall at rest, what the integral contributes to the required rates stays: the same
/// velocities of the rods after 6 s in place, by half of Λ and twice z. Tolerance: one rounding of z
/// a step of the fall.
#[test]
fn what_the_integral_contributes_stays_as_the_gains_fall() {
    let machine = Machine::reference();
    let mut settings = Settings {
        mode: Mode::Modular,
        integral: true,
        ..Settings::from_gains(&machine.controller)
    };
    settings.gains.settle_time = 70.0;
    let resting = Input {
        zeta: machine.start.zeta,
        ..Input::default()
    };
    let (network, path) = (Surrogate::reference(), Trajectory::Cubic);
    let mut controller =
        Controller::new(&machine, &network, path, &settings, &resting, 0.0).expect("valid");
    controller.state.integral = Vector6::new(1e-3, -2e-3, 3e-3, 1e-3, 2e-3, -1e-3);
    let before = controller.evaluate(&settings, &resting).expect("finite");
    for k in 0..600 {
        let now = controller.evaluate(&settings, &resting).expect("finite");
        let t = f64::from(k) * 1e-2;
        controller
            .step(&now, &settings, &resting, t, 1e-2)
            .expect("finite");
    }
    let after = controller.evaluate(&settings, &resting).expect("finite");
    let grown = controller.state.integral[0] / 1e-3;
    assert!((grown - 2.0).abs() < 1e-9, "{grown}");
    for i in 0..3 {
        let [v, w] = [&before, &after].map(|now| now.output.x_dot_required[i]);
        assert!(v.abs() > 1e-4 && (w - v).abs() < 1e-9, "{v} {w}");
    }
}
