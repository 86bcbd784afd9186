//! Tests the virtual power flows at the cuts between the bodies ([VPF]).
//!
//! At a cut the flow is `p = (V_r − V)ᵀ(F_r − F)`. It leaves one body and enters the next, so over
//! the whole machine the flows cancel in pairs and only those at the rods and the wrist motors
//! remain: the step of the stability proof from the bodies' accompanying functions to that of the
//! machine.

use super::{self as decomposition, BodyMotion};
use crate::bodies::Bounds;
use crate::signals::Input;
use crate::tracking::RequiredMotion;
use hdrm::{BODIES, Body, Configuration, DOF, Hdrm, Options, State};
use machine_file::Machine;
use nalgebra::Vector6;
use spatial::{Inertia, Wrench};

const GRAVITY: f64 = 9.81;
const KAPPA: f64 = 7.3;

/// One instant of a machine whose controller believes in other inertias.
struct Instant {
    configuration: Configuration,
    rate_error: [f64; DOF],
    motions: [BodyMotion; Body::COUNT],
    /// `F*_r − F*` of each body.
    net: [Wrench; Body::COUNT],
    /// Generalised forces required minus actual, by the production code of controller and plant.
    Q_error: [f64; DOF],
    /// Sum of the magnitudes that are added up, W.
    scale: f64,
}

/// Reproducible numbers in (−1, 1).
fn noise(k: usize, j: usize) -> f64 {
    (12.9898 * k as f64 + 78.233 * j as f64 + 0.37).sin()
}

fn instant(k: usize) -> Instant {
    let machine = Machine::reference();
    let plant = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid machine");
    let near = |j: usize, scale: f64| -> [f64; DOF] {
        std::array::from_fn(|i| scale * noise(k, 10 * j + i))
    };
    let zeta: [f64; DOF] = std::array::from_fn(|i| machine.start.zeta[i] + near(1, 0.25)[i]);
    let (zeta_dot, zeta_ddot) = (near(2, 0.4), near(3, 0.9));
    let required = RequiredMotion {
        zeta_dot: Vector6::from(near(4, 0.5)),
        zeta_ddot: Vector6::from(near(5, 1.1)),
    };
    let configuration = plant.tree().configuration(&zeta);
    // Every other machine stands on a base that moves.
    let moving = f64::from(u8::from(k % 2 == 1));
    let some =
        |j: usize, scale: f64| std::array::from_fn(|i| moving * scale * noise(k, 90 + j + i));
    let input = Input {
        base_tilt: [moving * 0.2 * noise(k, 88), moving * 0.3 * noise(k, 89)],
        base_acceleration: some(0, 2.0),
        base_angular_velocity: some(3, 0.8),
        base_angular_acceleration: some(6, 1.7),
        ..Input::default()
    };
    let ground = decomposition::ground(GRAVITY, &input);
    let motions = decomposition::motions(&configuration, &zeta_dot, &required, &ground);
    // The same recursion with the actual motion as the required one gives the actual accelerations.
    let actual = RequiredMotion {
        zeta_dot: Vector6::from(zeta_dot),
        zeta_ddot: Vector6::from(zeta_ddot),
    };
    let true_motions = decomposition::motions(&configuration, &zeta_dot, &actual, &ground);
    let believed: [Inertia; Body::COUNT] =
        std::array::from_fn(|b| plant.inertias()[b] * (1.0 + 0.4 * noise(k, 70 + b)));
    let estimates = std::array::from_fn(|b| {
        let bounds = Bounds::around(&believed[b], [0.2, 5.0]).expect("physical");
        bounds.nominal(believed[b])
    });
    let mut scale = 0.0;
    let net = std::array::from_fn(|b| {
        let (m, t) = (&motions[b], &true_motions[b]);
        let F_r = believed[b].apply(&m.w)
            + m.V.crf(&believed[b].apply(&m.V_r))
            + believed[b].apply(&(m.s() * KAPPA));
        let inertia = &plant.inertias()[b];
        let F = inertia.apply(&t.w) + t.V.crf(&inertia.apply(&t.V));
        let size = |F: &Wrench| F.to_vector().norm();
        scale += m.s().to_vector().norm() * (size(&F_r) + size(&F));
        F_r - F
    });
    let errors = decomposition::velocity_errors(&motions, &believed);
    let Q_r = decomposition::joint_forces(&configuration, &motions, &estimates, &errors, KAPPA);
    let state = State {
        zeta,
        zeta_dot,
        ..State::default()
    };
    // What moves the plant so, by how it moves without.
    let base = hdrm::Input {
        base_tilt: input.base_tilt,
        base_acceleration: input.base_acceleration,
        base_angular_velocity: input.base_angular_velocity,
        base_angular_acceleration: input.base_angular_acceleration,
        ..hdrm::Input::default()
    };
    let (M, _) = plant.equations_of_motion(&state);
    let free = Vector6::from(plant.forward_dynamics(&state, &base));
    let Q = M * (Vector6::from(zeta_ddot) - free);
    let friction = |i: usize| machine.joint_viscous[i] * zeta_dot[i];
    Instant {
        rate_error: std::array::from_fn(|i| required.zeta_dot[i] - zeta_dot[i]),
        Q_error: std::array::from_fn(|i| Q_r[i] - (Q[i] - friction(i))),
        configuration,
        motions,
        net,
        scale,
    }
}

/// What leaves the parent at a cut enters the child, apart from the power of the joint between
/// them; summed over all bodies, what is left are the joints. Tolerance: 13 bodies deep, some 100
/// rounded operations each, of the summed magnitudes.
#[test]
fn flows_cancel_in_pairs_at_every_cut() {
    for k in 0..200 {
        let Instant {
            configuration,
            rate_error,
            motions,
            net,
            scale,
            ..
        } = instant(k);
        let tolerance = 1300.0 * f64::EPSILON * scale;
        let mut cut = net;
        let (mut bodies, mut joints) = (0.0, 0.0);
        for body in BODIES.into_iter().rev() {
            let (b, link) = (body as usize, configuration.link(body));
            let entering = motions[b].s().power(&cut[b]);
            let joint = link.gear * rate_error[body.coordinate()] * body.axis().power(&cut[b]);
            let leaving = body.parent().map_or(0.0, |p| {
                let on_parent = link.pose.wrench_to_A(&cut[b]);
                cut[p as usize] += on_parent;
                motions[p as usize].s().power(&on_parent)
            });
            let pair = entering - joint - leaving;
            assert!(
                pair.abs() < tolerance,
                "instant {k}, cut of {body:?}: {pair:e} W"
            );
            bodies += motions[b].s().power(&net[b]);
            joints += joint;
        }
        let rest = bodies - joints;
        assert!(rest.abs() < tolerance, "instant {k}: {rest:e} W left");
        assert!(joints.abs() > 1e3 * tolerance, "instant {k}: nothing flows");
    }
}

/// The flow into all bodies is that of the three rods and the wrist motors, with the forces that
/// the controller's and the plant's own code give. Tolerance: as above, and the plant's specialised
/// path loses another factor of 100 by cancellation.
#[test]
fn the_bodies_take_what_the_rods_and_the_wrist_give() {
    for k in 0..200 {
        let now = instant(k);
        let bodies: f64 = BODIES
            .into_iter()
            .map(|b| now.motions[b as usize].s().power(&now.net[b as usize]))
            .sum();
        let rod = |i: usize| {
            let prime = now.configuration.strokes[i].prime;
            (prime * now.rate_error[i]) * (now.Q_error[i] / prime)
        };
        let wrist = |i: usize| now.rate_error[i] * now.Q_error[i];
        let given = (0..3).map(rod).sum::<f64>() + (3..DOF).map(wrist).sum::<f64>();
        let difference = bodies - given;
        assert!(
            difference.abs() < 1e5 * f64::EPSILON * now.scale,
            "instant {k}: {difference:e} W of {:e} W",
            now.scale
        );
    }
}

/// The bodies' energies of the velocity errors add up to `½ eᵀ M e`: e is the error of the joint
/// rates, M the plant's mass matrix, which is made in the boom's frame. Tolerance: 13 bodies' 36
/// products, cancelling by less than tenfold.
#[test]
fn the_energy_of_the_errors_is_that_of_the_mass_matrix() {
    let machine = Machine::reference();
    let plant = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid machine");
    for k in 0..20 {
        let now = instant(k);
        let start = machine.start.zeta;
        let state = State {
            zeta: std::array::from_fn(|i| start[i] + 0.25 * noise(k, 10 + i)),
            ..State::default()
        };
        let (M, _) = plant.equations_of_motion(&state);
        let e = Vector6::from(now.rate_error);
        let expected = 0.5 * e.dot(&(M * e));
        let found = decomposition::velocity_errors(&now.motions, plant.inertias()).energy;
        assert!(expected > 1.0, "{expected}");
        assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}");
    }
}

/// `√S M √S s`, with the plant's inertia matrix in place of ours; it takes energy out whatever the
/// shares. Tolerance: rounding of sums of 1 kN·m·s.
#[test]
fn feedback_with_shares_has_the_plants_inertia() {
    let machine = Machine::reference();
    let plant = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid machine");
    for k in 0..20 {
        let zeta: [f64; DOF] =
            std::array::from_fn(|i| machine.start.zeta[i] + 0.25 * noise(k, 10 + i));
        let s: [f64; DOF] = std::array::from_fn(|i| 0.4 * noise(k, 20 + i));
        let shares: [f64; DOF] = std::array::from_fn(|i| (1.0 + noise(k, 30 + i)).powi(2));
        let rest = State {
            zeta,
            ..State::default()
        };
        let (M, _) = plant.equations_of_motion(&rest);
        let roots = Vector6::from(shares.map(f64::sqrt));
        let scaled = roots.component_mul(&Vector6::from(s));
        let expected = roots.component_mul(&(M * scaled));
        let configuration = plant.tree().configuration(&zeta);
        let inertias = plant.inertias();
        let found = decomposition::shared_momentum(&configuration, inertias, &s, &shares);
        let found = Vector6::from(found.expect("shares"));
        assert!((found - expected).norm() < 1e-9 * expected.norm(), "{k}");
        assert!(found.dot(&Vector6::from(s)) > 0.0, "{k}");
    }
}
