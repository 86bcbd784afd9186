//! The stability proof in numbers along a run, for `study`, `causes` and the report: accompanying
//! functions, their derivative compared with the bound of the last theorem, and where the bound is
//! exceeded, the assumption of the proof that fails there.
//!
//! With ν = ν_1 + Σ ν_a the theorem says `ν' ≤ −B`, B the dissipation of bodies and actuators. The
//! excess `ν' + B` is the sum of
//! ```text
//! bodies     ν_1' + B_1 − p          p  = Σ (ẋ_r − ẋ)(f_r − F), with the measured force F at the rods
//! actuators  Σ ν_a' + B_a + p'       p' = Σ (ẋ_r − ẋ)·e_F, with the force error e_F of the proof, from the currents
//! cuts       p − p'
//! ```
//! In the proof the first two are ≤ 0 and the third is zero. In the machine the first is the effect
//! of sampling; the second that of sampling and of the parts of the voltage law that differ from the
//! printed one (motor-side velocity, filtered slope, integral part); the third is friction, inertia
//! and elasticity between current and rod, which the proof leaves out.
#![allow(non_snake_case)] // the paper's symbols

use anyhow::{Result, ensure};
use cosim::{Port, System, Verdict};
use serde::Serialize;
use surrogate::measurement::campaign::rms;

use super::gains::Gains;
use crate::measures::run::RecordedRun;
use crate::runs::grid::Plan;

/// Number of actuators.
const RODS: usize = 3;
/// Outputs of the controller that there are once.
const SCALARS: [&str; 3] = [
    "lyapunov.nu_velocity",
    "lyapunov.nu_adaptation",
    "lyapunov.dissipation",
];
/// Outputs of the controller for each actuator.
const PER_ROD: [&str; 5] = [
    "lyapunov.nu_actuator",
    "lyapunov.dissipation_actuator",
    "lyapunov.vpf",
    "lyapunov.force_error",
    "x_dot_required",
];
/// Outputs of the controller with the constants of the gain conditions.
const GAINS: [&str; 6] = [
    "stability.beta_1",
    "stability.beta_2",
    "stability.printed_margin",
    "stability.epsilon_max",
    "stability.K_1",
    "stability.K_2",
];

/// A power over a run, W.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Power {
    /// Mean.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
    /// Largest value.
    pub max: f64,
}

/// One run in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Trajectory.
    pub trajectory: &'static str,
    /// `paper` without the extensions of the voltage law, `shipped` with them.
    pub law: String,
    /// Communication step, s.
    pub step: f64,
    /// ν at the first sample of the motion, its largest and its last value, J.
    pub nu: [f64; 3],
    /// ν_1 without its adaptation part, as `nu`.
    pub nu_velocity: [f64; 3],
    /// Adaptation part of ν_1, as `nu`.
    pub nu_adaptation: [f64; 3],
    /// Σ ν_a, as `nu`.
    pub nu_actuators: [f64; 3],
    /// Dissipation B.
    pub dissipation: Power,
    /// ν'.
    pub nu_dot: Power,
    /// `ν' + B`: positive where the bound is exceeded.
    pub excess: Power,
    /// Share of the time in which the bound is exceeded.
    pub exceeded: f64,
    /// Part of the bodies in the excess.
    pub bodies: Power,
    /// Part of the actuators.
    pub actuators: Power,
    /// Part of the cuts at the rods.
    pub cuts: Power,
    /// Constants of the gain conditions.
    pub gains: Gains,
    /// Course over the motion.
    #[serde(skip)]
    pub course: Powers,
}

/// The accompanying functions, J, at the communication points of the motion, and the powers, W,
/// over the steps between them.
#[derive(Clone, Debug, Default)]
pub struct Powers {
    /// Time of the first point, s.
    pub start: f64,
    /// ν_1 without its adaptation part.
    pub nu_velocity: Vec<f64>,
    /// Adaptation part of ν_1.
    pub nu_adaptation: Vec<f64>,
    /// Σ ν_a.
    pub nu_actuators: Vec<f64>,
    /// ν'.
    pub nu_dot: Vec<f64>,
    /// Dissipation B; the bound of ν' is −B.
    pub dissipation: Vec<f64>,
    /// Part of the bodies in the excess `ν' + B`.
    pub bodies: Vec<f64>,
    /// Part of the actuators.
    pub actuators: Vec<f64>,
    /// Part of the cuts at the rods.
    pub cuts: Vec<f64>,
}

impl Powers {
    /// From the recorded [`SCALARS`], and [`PER_ROD`] with the rods' velocities, rod by rod each.
    /// Derivatives are differences over a step, powers their means over it; `times` and `step` in s.
    fn new(times: &[f64], scalars: &[&[f64]], per_rod: &[&[f64]], step: f64) -> Result<Self> {
        let points = times.len();
        ensure!(points > 1, "the motion has no step");
        let rods = |signal: usize| &per_rod[RODS * signal..][..RODS];
        let sum = |signal: usize, k: usize| rods(signal).iter().map(|c| c[k]).sum::<f64>();
        let [nu_velocity, nu_adaptation, B_1] = [0, 1, 2].map(|n| scalars[n]);
        let nu_actuators: Vec<f64> = (0..points).map(|k| sum(0, k)).collect();
        let nu = |k: usize| nu_velocity[k] + nu_adaptation[k] + nu_actuators[k];
        // B_a, p and p' of all actuators.
        let B_a = |k: usize| sum(1, k);
        let p = |k: usize| sum(2, k);
        let (error, required, actual) = (rods(3), rods(4), rods(5));
        let p_proof = |k: usize| -> f64 {
            (0..RODS)
                .map(|i| (required[i][k] - actual[i][k]) * error[i][k])
                .sum()
        };
        let mean = |power: &dyn Fn(usize) -> f64, k: usize| 0.5 * (power(k) + power(k + 1));
        let rate = |energy: &dyn Fn(usize) -> f64, k: usize| (energy(k + 1) - energy(k)) / step;
        let each =
            |power: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..points - 1).map(power).collect() };
        Ok(Self {
            start: times[0],
            nu_dot: each(&|k| rate(&nu, k)),
            dissipation: each(&|k| mean(&|k| B_1[k], k) + mean(&B_a, k)),
            bodies: each(&|k| {
                rate(&|k| nu_velocity[k], k) + rate(&|k| nu_adaptation[k], k) + mean(&|k| B_1[k], k)
                    - mean(&p, k)
            }),
            actuators: each(&|k| rate(&|k| nu_actuators[k], k) + mean(&B_a, k) + mean(&p_proof, k)),
            cuts: each(&|k| mean(&p, k) - mean(&p_proof, k)),
            nu_velocity: nu_velocity.to_vec(),
            nu_adaptation: nu_adaptation.to_vec(),
            nu_actuators,
        })
    }

    /// ν at the communication points, J.
    fn nu(&self) -> Vec<f64> {
        let total = |k: usize| self.nu_velocity[k] + self.nu_adaptation[k] + self.nu_actuators[k];
        (0..self.nu_velocity.len()).map(total).collect()
    }

    /// `ν' + B`: positive where the bound is exceeded.
    pub fn excess(&self) -> Vec<f64> {
        let parts = |k: usize| self.bodies[k] + self.actuators[k] + self.cuts[k];
        (0..self.nu_dot.len()).map(parts).collect()
    }
}

/// Makes a run and evaluates its motion.
pub(super) fn measure(system: &System, plan: &Plan) -> Result<(Run, Verdict)> {
    let controller = system.port(SCALARS[0])?.component;
    let arm = system.port("tip.position[1]")?.component;
    let outputs = |names: &[&str]| -> Result<Vec<Port>> {
        let ports = names.iter().map(|name| system.port_of(controller, name));
        ports.collect()
    };
    let (scalars, gains) = (outputs(&SCALARS)?, outputs(&GAINS)?);
    let per_rod = PER_ROD.map(|name| system.elements(controller, name, RODS));
    let mut per_rod = per_rod.into_iter().collect::<Result<Vec<_>>>()?.concat();
    per_rod.extend(system.elements(arm, "x_dot", RODS)?);
    let ports = [&scalars[..], &gains, &per_rod].concat();
    let recorded = RecordedRun::record(system, &plan.experiment, &ports)?;
    let columns = |ports: &[Port]| -> Result<Vec<&[f64]>> {
        ports.iter().map(|port| recorded.motion(*port)).collect()
    };
    let times = &recorded.recording.times[recorded.motion_start()..];
    let step = plan.experiment.stepping.step;
    let course = Powers::new(times, &columns(&scalars)?, &columns(&per_rod)?, step)?;
    // They are constant over a run.
    let constant = |k: usize| anyhow::Ok(recorded.recording.column(gains[k])?[0]);
    let excess = course.excess();
    let above = excess.iter().filter(|excess| **excess > 0.0).count();
    let run = Run {
        trajectory: plan.trajectory,
        law: plan.law.into(),
        step,
        nu: ends(&course.nu()),
        nu_velocity: ends(&course.nu_velocity),
        nu_adaptation: ends(&course.nu_adaptation),
        nu_actuators: ends(&course.nu_actuators),
        dissipation: Power::new(&course.dissipation),
        nu_dot: Power::new(&course.nu_dot),
        excess: Power::new(&excess),
        exceeded: above as f64 / excess.len() as f64,
        bodies: Power::new(&course.bodies),
        actuators: Power::new(&course.actuators),
        cuts: Power::new(&course.cuts),
        gains: Gains {
            beta_1: constant(0)?,
            beta_2: constant(1)?,
            printed_margin: constant(2)?,
            epsilon_max: constant(3)?,
            K_1: constant(4)?,
            K_2: constant(5)?,
        },
        course,
    };
    Ok((run, recorded.outcome.verdict()))
}

impl Power {
    fn new(values: &[f64]) -> Self {
        Self {
            mean: values.iter().fold(0.0, |sum, v| sum + v) / values.len() as f64,
            rms: rms(values.iter().copied()),
            max: largest(values),
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// First, largest and last value.
fn ends(values: &[f64]) -> [f64; 3] {
    [values[0], largest(values), values[values.len() - 1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ν = e^(−2t) falls with exactly ν' = −2ν: B = 2ν leaves nothing but the error of the
    /// differences, h²/12·ν''' < h². A flow that the actuators do not give shows at the cuts and,
    /// with the other sign, nowhere else.
    #[test]
    fn the_excess_is_split_by_its_cause() {
        let h = 1e-3;
        let nu: Vec<f64> = (0..100).map(|k| (-2.0 * h * f64::from(k)).exp()).collect();
        let zero = vec![0.0; nu.len()];
        let dissipation: Vec<f64> = nu.iter().map(|v| 2.0 * v + 0.5).collect();
        let flow = vec![0.5; nu.len()];
        let mut per_rod = [&zero[..]; 6 * RODS];
        per_rod[2 * RODS + 1] = &flow;
        let course = Powers::new(&zero, &[&nu, &zero, &dissipation], &per_rod, h).unwrap();
        let power = |values: &[f64]| Power::new(values);
        let (bodies, cuts) = (power(&course.bodies), power(&course.cuts));
        assert!(bodies.max.abs() < h * h, "{bodies:?}");
        assert_eq!(power(&course.actuators), Power::default());
        assert!((cuts.mean - 0.5).abs() < 1e-15);
        assert!((power(&course.excess()).max - 0.5).abs() < h * h);
        assert!(course.excess().iter().all(|excess| *excess > 0.0));
        assert_eq!(ends(&course.nu())[..2], [1.0, 1.0]);
        assert_eq!(course.nu_dot.len(), course.nu_velocity.len() - 1);
    }
}
