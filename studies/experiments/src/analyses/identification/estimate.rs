//! Weighted least squares of a machine's parameters for `run`; each body stays physically possible.
//!
//! ```text
//! minimise  Σ_k (F_k − F̂_k(p))²/σ_k² + Σ_bodies 2/s²·(tr Z − ln det(1 + Z)) + Σ_i p_i²/s_i²
//! ```
//! The pseudo-inertia of a body is `P = A (1 + Z) Aᵀ` with `P_0 = A Aᵀ` of the nominal one. The term
//! of a body is the divergence of its mass distribution from the nominal one (T. Lee, P. M. Wensing,
//! F. C. Park, *Geometric robot dynamic identification: a convex programming approach*, IEEE Trans.
//! Robotics 36(2), 2020): near it `‖Z‖²/s²`, and infinite where P is no longer positive definite. So
//! every body is possible, what the motion does not excite stays nominal, and the problem is convex:
//! Newton's method finds its only minimum. Each rod force and wrist torque has a weight, from its
//! residual, found in rounds. Dry friction, zeros of the load cells and gravity out of plumb are
//! estimated too, so that they are not taken for inertia; a machine file has no place for them.
#![allow(non_snake_case)] // the symbols of mechanics

use anyhow::{Context, Result, ensure};
use hdrm::{Body, DOF};
use machine_file::Machine;
use motion_check::Motion;
use nalgebra::{DMatrix, DVector, Matrix4};

use super::model::{
    COUNT, DRY, Model, SIDEWAYS, TEN, VISCOUS, ZERO, basis, coordinates, symmetric,
};

/// Prior standard deviation of an element of Z: 0.3 is a mass off by 15 %, or a centre of mass off by
/// some 20 % of the radius of gyration.
const INERTIAL_PRIOR: f64 = 0.3;
/// Prior standard deviations of viscous friction, as a part; of dry friction, N·m; of the zero of a
/// load cell, N; of gravity along x or z, m/s², 0.5° out of plumb.
const VISCOUS_PRIOR: f64 = 0.5;
const DRY_PRIOR: f64 = 300.0;
const ZERO_PRIOR: f64 = 300.0;
const SIDEWAYS_PRIOR: f64 = 0.09;
/// Standard deviations of the rod forces, N, and wrist torques, N·m: in the first round, and the
/// smallest that are accepted.
const FIRST: [f64; DOF] = [500.0, 500.0, 500.0, 50.0, 50.0, 50.0];
const LEAST: [f64; DOF] = [1.0, 1.0, 1.0, 0.1, 0.1, 0.1];
/// Time after which errors are independent, s: that of readings of up to 1.5 Hz.
const LASTING: f64 = 0.3;
/// Rounds of weights, and the most steps in each.
const ROUNDS: usize = 3;
const STEPS: usize = 40;
/// Below this rate, rad/s, a joint may stick: how much of its friction acts is unknown.
const STICKS: f64 = 0.01;

/// Measurements at one instant.
#[derive(Clone, Debug)]
pub struct Sample {
    pub motion: Motion,
    /// Rod forces, N, and wrist torques, N·m.
    pub forces: [f64; DOF],
}

/// The identified machine.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// The nominal machine with estimated bodies and viscous friction.
    pub machine: Machine,
    /// Residuals of the nominal machine, root mean square: rod forces, N, and wrist torques, N·m.
    pub nominal: [f64; DOF],
    /// Residuals of the estimate with its friction and zeros.
    pub residual: [f64; DOF],
}

/// Sums over the samples of one force: WᵀW, Wᵀy, yᵀy and the number of samples.
struct Sums {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
    count: f64,
}

impl Sums {
    fn zero() -> Self {
        Self {
            normal: DMatrix::zeros(COUNT, COUNT),
            right: DVector::zeros(COUNT),
            square: 0.0,
            count: 0.0,
        }
    }

    /// Sum of the squared residuals with these parameters.
    fn squares(&self, p: &DVector<f64>) -> f64 {
        let square = self.square - 2.0 * self.right.dot(p) + p.dot(&(&self.normal * p));
        square.max(0.0)
    }

    /// Root mean square of the residuals with these parameters.
    fn residual(&self, p: &DVector<f64>) -> f64 {
        (self.squares(p) / self.count.max(1.0)).sqrt()
    }
}

/// Estimates the parameters of the machine of `model` from samples that are `spacing` s apart.
pub fn estimate(model: &Model, samples: &[Sample], spacing: f64) -> Result<Estimate> {
    let sums = sums(model, samples);
    for (k, force) in sums.iter().enumerate() {
        ensure!(force.count > 10.0, "joint {} hardly moves", k + 1);
    }
    let (mut sizes, mut p) = (FIRST, DVector::zeros(COUNT));
    for _ in 0..ROUNDS {
        let mut all = Sums::zero();
        for (force, size) in sums.iter().zip(sizes) {
            let weight = (spacing / LASTING).min(1.0) / (size * size);
            all.normal += &force.normal * weight;
            all.right += &force.right * weight;
            all.square += force.square * weight;
        }
        p = minimise(&all, p)?;
        sizes = std::array::from_fn(|k| sums[k].residual(&p).max(LEAST[k]));
    }
    let bodies: Vec<_> = (0..Body::COUNT).map(|k| factor(&p, k)).collect();
    let viscous: Vec<f64> = (VISCOUS..DRY).map(|k| 1.0 + p[k]).collect();
    let machine = model.with(&bodies, &viscous);
    machine.check().context("the machine as estimated")?;
    let residuals = |p: &DVector<f64>| std::array::from_fn(|k| sums[k].residual(p));
    Ok(Estimate {
        machine,
        nominal: residuals(&DVector::zeros(COUNT)),
        residual: residuals(&p),
    })
}

fn sums(model: &Model, samples: &[Sample]) -> Vec<Sums> {
    let mut sums: Vec<_> = (0..DOF).map(|_| Sums::zero()).collect();
    for Sample { motion, forces } in samples {
        let (nominal, by_parameter) = model.forces(motion);
        for (k, sums) in sums.iter_mut().enumerate() {
            if motion.zeta_dot[k].abs() < STICKS {
                continue;
            }
            let w = by_parameter.row(k).transpose();
            let y = forces[k] - nominal[k];
            sums.normal.ger(1.0, &w, &w, 1.0);
            sums.right.axpy(y, &w, 1.0);
            sums.square += y * y;
            sums.count += 1.0;
        }
    }
    sums
}

/// The parameters that minimise the cost, by Newton's method from `p` on with halved steps.
fn minimise(sums: &Sums, mut p: DVector<f64>) -> Result<DVector<f64>> {
    let mut cost = cost(sums, &p).context("a start without bodies")?;
    for _ in 0..STEPS {
        let mut slope = &sums.normal * &p - &sums.right;
        let mut H = sums.normal.clone();
        add_prior(&p, &mut slope, &mut H);
        let step = H.cholesky().context("no step")?.solve(&slope);
        let mut part = 1.0;
        let (next, lower) = loop {
            let next = &p - &step * part;
            match self::cost(sums, &next) {
                Some(lower) if lower <= cost => break (next, lower),
                _ if part < 1e-6 => return Ok(p),
                _ => part *= 0.5,
            }
        };
        (p, cost) = (next, lower);
        if step.amax() < 1e-9 {
            break;
        }
    }
    Ok(p)
}

/// `1 + Z` of a body.
fn factor(p: &DVector<f64>, body: usize) -> Matrix4<f64> {
    Matrix4::identity() + symmetric(p.rows(TEN * body, TEN).as_slice())
}

/// The cost that is minimised; None where a body is not possible, or friction is negative.
fn cost(sums: &Sums, p: &DVector<f64>) -> Option<f64> {
    let mut prior = 0.0;
    for k in 0..Body::COUNT {
        let factor = factor(p, k);
        let ln_det = 2.0 * factor.cholesky()?.l().diagonal().map(f64::ln).sum();
        prior += 2.0 / INERTIAL_PRIOR.powi(2) * (factor.trace() - 4.0 - ln_det);
    }
    for k in VISCOUS..DRY {
        (p[k] > -1.0).then_some(())?;
        prior += 2.0 / VISCOUS_PRIOR.powi(2) * (p[k] - p[k].ln_1p());
    }
    let rest = (DRY..COUNT).map(|k| (p[k] / deviation(k)).powi(2));
    Some(sums.squares(p) + prior + rest.sum::<f64>())
}

/// Adds half of the prior's gradient and second derivatives: of `tr Z − ln det(1 + Z)` they are
/// `1 − W` and `E ↦ W E W` with `W = (1 + Z)⁻¹`.
fn add_prior(p: &DVector<f64>, slope: &mut DVector<f64>, H: &mut DMatrix<f64>) {
    let weight = INERTIAL_PRIOR.powi(-2);
    for k in 0..Body::COUNT {
        let W = factor(p, k).try_inverse().expect("positive definite");
        let along = coordinates(&(Matrix4::identity() - W)) * weight;
        let mut own = slope.rows_mut(TEN * k, TEN);
        own += along;
        for (j, E) in basis().iter().enumerate() {
            let mut own = H.view_mut((TEN * k, TEN * k + j), (TEN, 1));
            own += coordinates(&(W * E * W)) * weight;
        }
    }
    for k in VISCOUS..DRY {
        let (weight, inverse) = (VISCOUS_PRIOR.powi(-2), 1.0 / (1.0 + p[k]));
        slope[k] += weight * (1.0 - inverse);
        H[(k, k)] += weight * inverse * inverse;
    }
    for k in DRY..COUNT {
        let weight = deviation(k).powi(-2);
        slope[k] += weight * p[k];
        H[(k, k)] += weight;
    }
}

/// Prior standard deviation of a parameter that machine files do not have.
fn deviation(k: usize) -> f64 {
    match k {
        DRY..ZERO => DRY_PRIOR,
        ZERO..SIDEWAYS => ZERO_PRIOR,
        _ => SIDEWAYS_PRIOR,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyses::identification::excitation::{DURATION, Excitation};
    use crate::worlds::perturbation::{Bounds, draw};
    use motion_check::{DemandModel, Payload};

    const SPACING: f64 = 0.05;

    /// Forces of a drawn machine on a motion, by its own inverse dynamics.
    fn samples(machine: &Machine, motion: &Excitation) -> Vec<Sample> {
        let plant = DemandModel::new(machine, &Payload::from_machine(machine)).expect("a machine");
        let count = (DURATION / SPACING) as u32;
        let times = (0..count).map(|k| SPACING * f64::from(k));
        let sample = |t| {
            let motion = motion.at(t);
            let demand = plant.demand(&motion);
            let ([a, b, c], [d, e, f]) = (demand.f, demand.tau_wrist);
            let forces = [a, b, c, d, e, f];
            Sample { motion, forces }
        };
        times.map(sample).collect()
    }

    /// Root mean square of the difference of forces, of each over that of the force.
    fn parts(found: &[Sample], truth: &[Sample]) -> [f64; DOF] {
        let squares = |part: f64, k: usize| -> f64 {
            let pairs = found.iter().zip(truth);
            let difference = |(a, b): (&Sample, &Sample)| part * a.forces[k] - b.forces[k];
            pairs.map(|pair| difference(pair).powi(2)).sum()
        };
        std::array::from_fn(|k| (squares(1.0, k) / squares(0.0, k)).sqrt())
    }

    /// Exact forces of a machine off by up to 40 % with 50 mm: on another motion than the one that
    /// excited it, every force is predicted to one per cent, where the nominal machine is off by
    /// up to 15 and more. What is left is the prior's, against forces that are believed to 1 N and
    /// 0.1 N·m.
    #[test]
    fn the_forces_of_another_motion_are_predicted() {
        let nominal = Machine::reference();
        let model = Model::new(&nominal).expect("a model");
        let motion = |seed| {
            let drawn = Excitation::draw(&model, seed).expect("works");
            drawn.expect("a motion")
        };
        let (exciting, other) = (Excitation::best(&model).expect("a motion"), motion(1000));
        let bounds = Bounds {
            length: 0.0,
            plumb: 0.0,
            ..Bounds::REAL
        };
        for seed in [3, 4, 5, 6] {
            let (machine, _) = draw(&nominal, seed, &bounds).expect("a machine");
            let found = estimate(&model, &samples(&machine, &exciting), SPACING).expect("works");
            let [found, truth, nominal] =
                [&found.machine, &machine, &nominal].map(|machine| samples(machine, &other));
            let (found, nominal) = (parts(&found, &truth), parts(&nominal, &truth));
            assert!(found.iter().all(|part| *part < 0.01), "{seed}: {found:?}");
            assert!(nominal.iter().any(|part| *part > 0.15), "{nominal:?}");
        }
    }

    /// Forces that no machine has, ten times the weights with either sign, give bodies that exist.
    #[test]
    fn bodies_exist_whatever_is_measured() {
        let nominal = Machine::reference();
        let model = Model::new(&nominal).expect("a model");
        let exciting = Excitation::draw(&model, 2).expect("works").expect("motion");
        let mut wrong = samples(&nominal, &exciting);
        for (k, sample) in wrong.iter_mut().enumerate() {
            let factor = if k % 7 < 3 { -10.0 } else { 4.0 };
            sample.forces.iter_mut().for_each(|f| *f *= factor);
        }
        let found = estimate(&model, &wrong, SPACING).expect("a machine");
        assert_ne!(found.machine, nominal);
    }

    /// Slope and second derivatives of the prior are those of the cost, by central differences of
    /// step h: h² times third derivatives of 2/s²·10 over 6 is 1e-6.
    #[test]
    fn the_prior_s_derivatives_are_those_of_the_cost() {
        let mut p = DVector::from_fn(COUNT, |k, _| 0.1 * (1.0 + k as f64).sin());
        p.rows_mut(0, TEN).scale_mut(3.0);
        let sums = Sums::zero();
        let slope = |p: &DVector<f64>| {
            let (mut slope, mut H) = (DVector::zeros(COUNT), DMatrix::zeros(COUNT, COUNT));
            add_prior(p, &mut slope, &mut H);
            (slope, H)
        };
        let (now, H) = slope(&p);
        let h = 1e-5;
        for k in (0..COUNT).step_by(7) {
            let moved = |h: f64| {
                let mut moved = p.clone();
                moved[k] += h;
                moved
            };
            let [up, down] = [moved(h), moved(-h)];
            let half = |p| 0.5 * cost(&sums, p).expect("bodies");
            let first = (half(&up) - half(&down)) / (2.0 * h);
            assert!((first - now[k]).abs() < 1e-5, "{k}: {first} {}", now[k]);
            let second = (slope(&up).0 - slope(&down).0) / (2.0 * h);
            assert!((second - H.column(k)).amax() < 1e-5, "{k}");
        }
    }
}
