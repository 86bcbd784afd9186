//! The forces of a machine of known dimensions as a linear function of its parameters, for its
//! identification: `excitation`, `estimate` and `run` compute with them.
//!
//! Rod forces and wrist torques are linear in the mass, first moment and inertia of each body,
//! hence in its pseudo-inertia `P`, and in what else acts on the joints. With `P = A (1 + Z) Aᵀ`,
//! `P_0 = A Aᵀ` of the nominal body, the ten elements of the symmetric `Z` describe a body, all of
//! the same magnitude whether it weighs 5 or 500 kg.
#![allow(non_snake_case)] // the symbols of mechanics

use anyhow::{Context, Result};
use hdrm::{Body, DOF, Hdrm, Options, State};
use machine_file::{InertiaTensor, Machine};
use motion_check::Motion;
use nalgebra::{DMatrix, DVector, Matrix4};
use serde::Serialize;
use spatial::{Inertia, PseudoInertia};

/// Parameters of a body.
pub(super) const TEN: usize = 10;
/// Parameters of all bodies.
pub(super) const INERTIAL: usize = Body::COUNT * TEN;
/// Index of the first parameter of viscous friction, as a part of the nominal one; of dry friction,
/// N·m; of the zeros of the load cells, N; of gravity along x and z, m/s²; number of parameters.
pub(super) const VISCOUS: usize = INERTIAL;
pub(super) const DRY: usize = VISCOUS + DOF;
pub(super) const ZERO: usize = DRY + DOF;
pub(super) const SIDEWAYS: usize = ZERO + 3;
pub(super) const COUNT: usize = SIDEWAYS + 2;

/// A step in `Z` at which every body is still possible: the unit matrices have eigenvalues from
/// −0.71.
const STEP: f64 = 0.5;
/// A column counts as dependent on the columns before it if less than this part of it is left
/// without them: load cells of 1 % could not tell it apart.
const SAME: f64 = 0.01;

/// How well a motion distinguishes the bodies' parameters.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Condition {
    /// Number of independent ones, the base parameters.
    pub base: usize,
    /// Condition number of their columns, each scaled to length 1.
    pub number: f64,
}

/// The nominal machine, and a machine for each parameter that differs in it alone.
pub struct Model {
    pub(super) machine: Machine,
    nominal: Hdrm,
    bodies: Vec<Hdrm>,
    sideways: [Hdrm; 2],
    /// A of each body.
    roots: Vec<Matrix4<f64>>,
}

impl Model {
    pub fn new(machine: &Machine) -> Result<Self> {
        let options = Options::from_machine(machine);
        let root = |body: &machine_file::Body| -> Result<Matrix4<f64>> {
            let cholesky = pseudo_inertia(body).0.cholesky();
            Ok(cholesky.context("a body that cannot exist")?.l())
        };
        let roots: Vec<_> = (machine.bodies.in_order().into_iter())
            .map(root)
            .collect::<Result<_>>()?;
        let mut bodies = Vec::new();
        for (k, A) in roots.iter().enumerate() {
            for basis in basis() {
                let mut other = machine.clone();
                let L = A * (Matrix4::identity() + basis * STEP) * A.transpose();
                *other.bodies.in_order_mut()[k] = body(&PseudoInertia(L));
                bodies.push(Hdrm::new(&other, &Options::from_machine(&other))?);
            }
        }
        let [_, g, _] = options.gravity;
        let along = |gravity: [f64; 3]| {
            let mut options = options;
            options.gravity = gravity;
            Hdrm::new(machine, &options)
        };
        Ok(Self {
            machine: machine.clone(),
            nominal: Hdrm::new(machine, &options)?,
            bodies,
            sideways: [along([1.0, g, 0.0])?, along([0.0, g, 1.0])?],
            roots,
        })
    }

    /// The machine whose bodies have these `1 + Z`, and whose viscous friction is the nominal one
    /// times these factors.
    pub fn with(&self, bodies: &[Matrix4<f64>], viscous: &[f64]) -> Machine {
        let mut machine = self.machine.clone();
        let each = self.roots.iter().zip(bodies);
        for (own, (A, factor)) in machine.bodies.in_order_mut().into_iter().zip(each) {
            *own = body(&PseudoInertia(A * factor * A.transpose()));
        }
        for (own, factor) in machine.joint_viscous.iter_mut().zip(viscous) {
            *own *= factor;
        }
        machine
    }

    /// Nominal rod forces, N, and wrist torques, N·m, at a motion, and their derivatives by the
    /// parameters, a row for each.
    pub fn forces(&self, motion: &Motion) -> ([f64; DOF], DMatrix<f64>) {
        let (zeta, zeta_dot, zeta_ddot) = (motion.zeta, motion.zeta_dot, &motion.zeta_ddot);
        let state = State {
            zeta,
            zeta_dot,
            ..State::default()
        };
        let forces = |plant: &Hdrm| -> [f64; DOF] {
            let ([a, b, c], [d, e, f]) = plant.inverse_dynamics(&state, zeta_ddot, &[0.0; DOF]);
            [a, b, c, d, e, f]
        };
        let nominal = forces(&self.nominal);
        let mut by_parameter = DMatrix::zeros(DOF, COUNT);
        let mut set = |column: usize, plant: &Hdrm, step: f64| {
            for (k, (with, without)) in forces(plant).into_iter().zip(nominal).enumerate() {
                by_parameter[(k, column)] = (with - without) / step;
            }
        };
        for (column, plant) in self.bodies.iter().enumerate() {
            set(column, plant, STEP);
        }
        for (k, plant) in self.sideways.iter().enumerate() {
            set(SIDEWAYS + k, plant, 1.0);
        }
        let strokes = self.nominal.tree().configuration(&zeta).strokes;
        for k in 0..DOF {
            let lever = strokes.get(k).map_or(1.0, |stroke| stroke.prime);
            let w = zeta_dot[k];
            by_parameter[(k, VISCOUS + k)] = self.machine.joint_viscous[k] * w / lever;
            by_parameter[(k, DRY + k)] = w.signum() / lever;
        }
        for k in 0..3 {
            by_parameter[(k, ZERO + k)] = 1.0;
        }
        (nominal, by_parameter)
    }

    /// How well `motions` distinguish the bodies' parameters, with rod forces and wrist torques
    /// relative to the machine's largest.
    pub fn condition(&self, motions: impl Iterator<Item = Motion>) -> Condition {
        let rods = self.machine.ratings.in_order().map(|r| r.force_max);
        let wrist = self.machine.limits.tau_wrist_max;
        let mut normal = DMatrix::zeros(INERTIAL, INERTIAL);
        for motion in motions {
            let (_, mut by_parameter) = self.forces(&motion);
            for (k, most) in rods.iter().chain(&wrist).enumerate() {
                by_parameter.row_mut(k).scale_mut(1.0 / most);
            }
            let bodies = by_parameter.columns(0, INERTIAL);
            normal += bodies.transpose() * bodies;
        }
        condition(normal)
    }
}

/// Condition of columns with this normal matrix. The independent ones are found by Cholesky's
/// decomposition with pivoting, which orthogonalises the columns.
fn condition(mut normal: DMatrix<f64>) -> Condition {
    let lengths = normal.diagonal().map(f64::sqrt);
    let largest = lengths.max();
    let seen: Vec<usize> = (0..normal.nrows())
        .filter(|k| lengths[*k] > SAME * SAME * largest)
        .collect();
    normal = normal.select_rows(&seen).select_columns(&seen);
    for (k, a) in seen.iter().enumerate() {
        for (j, b) in seen.iter().enumerate() {
            normal[(k, j)] /= lengths[*a] * lengths[*b];
        }
    }
    let mut rest = normal.clone();
    let mut base = Vec::new();
    while base.len() < seen.len() {
        let (pivot, left) = rest.diagonal().argmax();
        if left < SAME * SAME {
            break;
        }
        base.push(pivot);
        let column = rest.column(pivot).clone_owned();
        rest -= &column * column.transpose() / left;
        rest[(pivot, pivot)] = 0.0;
    }
    let values = (normal.select_rows(&base).select_columns(&base)).symmetric_eigenvalues();
    Condition {
        base: base.len(),
        number: (values.max() / values.min()).sqrt(),
    }
}

/// Orthonormal basis of the symmetric matrices.
pub(super) fn basis() -> [Matrix4<f64>; TEN] {
    let mut all = [Matrix4::zeros(); TEN];
    let pairs = (0..4).flat_map(|i| (i..4).map(move |j| (i, j)));
    for (E, (i, j)) in all.iter_mut().zip(pairs) {
        let size = if i == j { 1.0 } else { 0.5_f64.sqrt() };
        (E[(i, j)], E[(j, i)]) = (size, size);
    }
    all
}

/// Coordinates in [`basis`].
pub(super) fn coordinates(S: &Matrix4<f64>) -> DVector<f64> {
    DVector::from_iterator(TEN, basis().iter().map(|E| E.dot(S)))
}

/// The matrix with these coordinates in [`basis`].
pub(super) fn symmetric(coordinates: &[f64]) -> Matrix4<f64> {
    let each = basis().into_iter().zip(coordinates);
    each.map(|(E, x)| E * *x).sum()
}

fn pseudo_inertia(body: &machine_file::Body) -> PseudoInertia {
    let I_com = body.inertia_com.rows().into();
    (&Inertia::from_com(body.mass, body.com.into(), I_com)).into()
}

fn body(L: &PseudoInertia) -> machine_file::Body {
    let about_origin = Inertia::from(L);
    let com = about_origin.h / about_origin.m;
    let I = about_origin.shifted(&-com).I;
    machine_file::Body {
        mass: about_origin.m,
        com: com.into(),
        inertia_com: InertiaTensor {
            xx: I[(0, 0)],
            yy: I[(1, 1)],
            zz: I[(2, 2)],
            xy: I[(0, 1)],
            xz: I[(0, 2)],
            yz: I[(1, 2)],
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::perturbation::{Bounds, draw};

    /// A drawn machine of nominal dimensions has the forces of its parameters, by its own inverse
    /// dynamics; 1e-8 of them is rounding over the step of one half.
    #[test]
    fn forces_are_linear_in_the_parameters() {
        let nominal = Machine::reference();
        let bounds = Bounds {
            length: 0.0,
            plumb: 0.0,
            ..Bounds::REAL
        };
        let (drawn, _) = draw(&nominal, 5, &bounds).expect("a machine");
        let model = Model::new(&nominal).expect("a model");
        let mut p = DVector::zeros(COUNT);
        for (k, body) in drawn.bodies.in_order().into_iter().enumerate() {
            let inverse = model.roots[k].try_inverse().expect("regular");
            let Z = inverse * pseudo_inertia(body).0 * inverse.transpose() - Matrix4::identity();
            p.rows_mut(TEN * k, TEN).copy_from(&coordinates(&Z));
        }
        for k in 0..DOF {
            p[VISCOUS + k] = drawn.joint_viscous[k] / nominal.joint_viscous[k] - 1.0;
        }
        let motion = Motion {
            zeta: [0.3, 0.5, -1.2, 0.4, -0.7, 0.2],
            zeta_dot: [0.2, -0.1, 0.15, 0.4, -0.3, 0.5],
            zeta_ddot: [0.5, 0.3, -0.4, 1.0, 0.7, -1.2],
        };
        let (forces, by_parameter) = model.forces(&motion);
        let predicted = DVector::from_row_slice(&forces) + by_parameter * &p;
        let state = State {
            zeta: motion.zeta,
            zeta_dot: motion.zeta_dot,
            ..State::default()
        };
        let plant = Hdrm::new(&drawn, &Options::from_machine(&drawn)).expect("a plant");
        let (f, tau) = plant.inverse_dynamics(&state, &motion.zeta_ddot, &[0.0; DOF]);
        for (k, force) in f.into_iter().chain(tau).enumerate() {
            assert!(
                (predicted[k] - force).abs() < 1e-8 * force.abs().max(1e3),
                "{k}"
            );
        }
    }

    /// Two directions at 60° have singular values √(1 ± ½), whatever their lengths; a third column
    /// along the first is none of the base, one of zeros is not seen.
    #[test]
    fn the_condition_is_that_of_independent_columns() {
        let s = 3.0_f64.sqrt();
        let W = DMatrix::from_row_slice(2, 4, &[3.0, 1.0, -0.5, 0.0, 0.0, s, 0.0, 0.0]);
        let found = condition(W.transpose() * &W);
        assert_eq!(found.base, 2);
        assert!((found.number - 3.0_f64.sqrt()).abs() < 1e-9, "{found:?}");
    }
}
