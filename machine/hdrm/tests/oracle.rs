//! The plant against an independent Lagrangian by automatic differentiation of body poses
//! (`tests/oracle/lagrangian.py`, JAX): the reference machine, one without any symmetry (bodies off
//! the plane, full inertia tensors) with scaled inertia and another payload, and the loader crane
//! `hiab_xs031`.
use hdrm::{Hdrm, Input, Load, Options, State};
use machine_file::Machine;
use nalgebra::{DVector, Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::Deserialize;
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
    zeta_ddot: [f64; 6],
    x: [f64; 3],
    x_dot: [f64; 3],
    f_hold: [f64; 3],
    tau_hold: [f64; 3],
    kinetic: f64,
    potential: f64,
    tip_position: [f64; 3],
    tip_rotation: [f64; 9],
    tip_twist: [f64; 6],
}

impl Case {
    fn state(&self) -> State {
        State {
            zeta: self.zeta,
            zeta_dot: self.zeta_dot,
            ..State::default()
        }
    }

    fn input(&self) -> Input {
        Input {
            f: self.f,
            tau_wrist: self.tau,
            wrench_env: self.W_env,
            ..Input::default()
        }
    }
}

fn plants() -> Vec<(Hdrm, Vec<Case>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/oracle/manipulator.json");
    let text = std::fs::read_to_string(&path).expect("golden file");
    let golden: Golden = serde_json::from_str(&text).expect("golden format");
    let build = |plant: Plant| {
        plant.machine.check().expect("physical machine");
        let options = Options {
            inertia_scale: plant.inertia_scale,
            load: Load {
                payload_mass: plant.payload_mass,
                ..Load::from_machine(&plant.machine)
            },
            ..Options::from_machine(&plant.machine)
        };
        let hdrm = Hdrm::new(&plant.machine, &options).expect("working machine");
        (hdrm, plant.cases)
    };
    golden.plants.into_iter().map(build).collect()
}

/// `|a − b| / |b|`.
fn relative_error(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (DVector::from_column_slice(a), DVector::from_column_slice(b));
    (a - &b).norm() / b.norm()
}

/// Tolerance 1e-10 relative, by requirement. Rounding gives some κ(M)·ε with κ ≈ 1e4, that is
/// 1e-12; a swapped term gives at least 1e-3.
#[test]
fn accelerations_equal_the_lagrangian() {
    let mut worst: f64 = 0.0;
    let mut count = 0;
    for (hdrm, cases) in plants() {
        for case in cases {
            let zeta_ddot = hdrm.forward_dynamics(&case.state(), &case.input());
            let error = relative_error(&zeta_ddot, &case.zeta_ddot);
            worst = worst.max(error);
            count += 1;
            assert!(
                error < 1e-10,
                "{error:e} at {:?}, {:?}",
                case.zeta,
                case.zeta_dot
            );
        }
    }
    println!("worst relative acceleration error of {count} states: {worst:e}");
    assert!(count >= 300);
}

/// The recursion over the tree, which shares no code with the forward path, inverts it.
#[test]
fn inverse_dynamics_give_back_the_forces() {
    for (hdrm, cases) in plants() {
        for case in cases {
            let (f, tau) = hdrm.inverse_dynamics(&case.state(), &case.zeta_ddot, &case.W_env);
            let error = relative_error(&[f, tau].concat(), &[case.f, case.tau].concat());
            assert!(
                error < 1e-10,
                "{error:e} at {:?}, {:?}",
                case.zeta,
                case.zeta_dot
            );
        }
    }
}

#[test]
fn outputs_equal_the_lagrangian() {
    for (hdrm, cases) in plants() {
        for case in cases {
            let out = hdrm.output(&case.state(), &case.input());
            let R = Matrix3::from_row_slice(&case.tip_rotation);
            let [w, i, j, k] = out.tip_orientation;
            let q = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
            let turn = |v: &[f64]| R * Vector3::from_column_slice(v);
            let (v, w) = (turn(&case.tip_twist[..3]), turn(&case.tip_twist[3..]));
            let velocity = [v.as_slice(), w.as_slice()].concat();
            let quaternion_error = (q.to_rotation_matrix().matrix() - R).norm();
            for (what, error) in [
                ("x", relative_error(&out.x, &case.x)),
                ("x_dot", relative_error(&out.x_dot, &case.x_dot)),
                ("f_hold", relative_error(&out.f_hold, &case.f_hold)),
                ("tau_hold", relative_error(&out.tau_hold, &case.tau_hold)),
                ("kinetic", out.energy_kinetic / case.kinetic - 1.0),
                ("potential", out.energy_potential / case.potential - 1.0),
                (
                    "position",
                    relative_error(&out.tip_position, &case.tip_position),
                ),
                ("orientation", quaternion_error),
                ("velocity", relative_error(&out.tip_velocity, &velocity)),
            ] {
                assert!(error.abs() < 1e-11, "{what}: {error:e} at {:?}", case.zeta);
            }
        }
    }
}
