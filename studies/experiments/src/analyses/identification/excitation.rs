//! The motion that excites a machine for its identification (in module `run`): each joint follows a
//! Fourier series of five harmonics, for two periods, from rest in the start pose back to rest.
//!
//! Source: J. Swevers, C. Ganseman, D. B. Tükel, J. De Schutter, H. Van Brussel, *Optimal robot
//! excitation and identification*, IEEE Trans. Robotics and Automation 13(5), 1997. Of some series
//! drawn at random, each as large as the machine allows, the best conditioned one is taken.

use std::f64::consts::TAU;

use anyhow::{Context, Result, ensure};
use hdrm::{DOF, Tree};
use machine_file::Machine;
use motion_check::{Kinematics, Motion};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde_json::json;
use tip_path::{Finding, PathFile, TipPath, check};

use super::model::{Condition, Model};

/// Lowest frequency, Hz, number of its harmonics, and of periods.
const FREQUENCY: f64 = 0.1;
const HARMONICS: usize = 5;
const PERIODS: f64 = 2.0;
/// Length, s.
pub const DURATION: f64 = PERIODS / FREQUENCY;
/// Largest distance of a joint from the start pose, rad, and as a part of what its range allows.
const WAY: f64 = 0.6;
const PART: f64 = 0.7;
/// Largest rod speed as a part of the rated one.
const SPEED: f64 = 0.9;
/// Number of series that are drawn.
const DRAWN: u64 = 96;
/// Time between points of the path and of the check of the ranges, s.
const STEP: f64 = 0.05;
/// Time between points at which the condition is evaluated, s.
const COARSE: f64 = 0.2;
/// A series that the machine cannot follow is made smaller by this factor, at most so often.
const SMALLER: f64 = 0.8;
const ATTEMPTS: u32 = 12;

/// Joint `q(t) = q_0 + Σ_l a_l/(ω l)·sin(ω l t) + b_l/(ω l)·(1 − cos(ω l t))` with `Σ a_l = 0` and
/// `Σ l·b_l = 0`, so that rate and acceleration are zero at the ends.
#[derive(Clone, Copy, Debug)]
struct Series {
    start: f64,
    a: [f64; HARMONICS],
    b: [f64; HARMONICS],
}

impl Series {
    fn draw(start: f64, random: &mut ChaCha8Rng) -> Self {
        let mut draw =
            || -> [f64; HARMONICS] { std::array::from_fn(|_| StandardNormal.sample(&mut *random)) };
        let (mut a, mut b) = (draw(), draw());
        let mean = a.iter().sum::<f64>() / HARMONICS as f64;
        a.iter_mut().for_each(|a| *a -= mean);
        let number = |k: usize| (k + 1) as f64;
        let squares: f64 = (0..HARMONICS).map(|k| number(k).powi(2)).sum();
        let along = (0..HARMONICS).map(|k| number(k) * b[k]).sum::<f64>() / squares;
        for (k, b) in b.iter_mut().enumerate() {
            *b -= along * number(k);
        }
        Self { start, a, b }
    }

    fn scaled(mut self, factor: f64) -> Self {
        for value in self.a.iter_mut().chain(&mut self.b) {
            *value *= factor;
        }
        self
    }

    /// Angle, rate and acceleration.
    fn at(&self, t: f64) -> [f64; 3] {
        let mut value = [self.start, 0.0, 0.0];
        for (k, (a, b)) in self.a.iter().zip(self.b).enumerate() {
            let w = TAU * FREQUENCY * (k + 1) as f64;
            let (sin, cos) = (w * t).sin_cos();
            value[0] += (a * sin + b * (1.0 - cos)) / w;
            value[1] += a * cos + b * sin;
            value[2] += w * (b * cos - a * sin);
        }
        value
    }
}

/// The motion that excites a machine.
#[derive(Clone, Debug)]
pub struct Excitation {
    series: [Series; DOF],
    /// How well it distinguishes the parameters.
    pub condition: Condition,
}

impl Excitation {
    /// The best of some drawn motions for the machine of `model`.
    pub fn best(model: &Model) -> Result<Self> {
        let drawn = (0..DRAWN).into_par_iter();
        let drawn = drawn.filter_map(|seed| Self::draw(model, seed).transpose());
        let drawn: Vec<Self> = drawn.collect::<Result<_>>()?;
        let best = drawn
            .into_iter()
            .min_by(|a, b| a.condition.number.total_cmp(&b.condition.number));
        best.context("no motion that excites the machine is within its limits")
    }

    /// The motion of a seed; None where the machine cannot follow it.
    pub fn draw(model: &Model, seed: u64) -> Result<Option<Self>> {
        let machine = &model.machine;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let zeta = machine.start.zeta;
        let tree = Tree::new(machine)?;
        let mut series = zeta.map(|start| Series::draw(start, &mut random));
        let strokes = tree.configuration(&zeta).strokes;
        for (k, series) in series.iter_mut().enumerate() {
            let range = machine.limits.zeta()[k];
            let free = (zeta[k] - range[0]).min(range[1] - zeta[k]);
            let (mut way, mut speed) = (0.0_f64, 0.0_f64);
            for t in times(STEP) {
                let [angle, rate, _] = series.at(t);
                way = way.max((angle - zeta[k]).abs());
                if k < 3 {
                    speed = speed.max((strokes[k].prime * rate).abs());
                }
            }
            let mut factor = WAY.min(PART * free) / way;
            if k < 3 {
                let rated = machine.ratings.in_order()[k].rod_speed_max;
                factor = factor.min(SPEED * rated / speed);
            }
            *series = series.scaled(factor);
        }
        let condition = Condition::default();
        let mut motion = Self { series, condition };
        for _ in 0..ATTEMPTS {
            if motion.is_possible(machine)? {
                let motions = times(COARSE).map(|t| motion.at(t));
                motion.condition = model.condition(motions);
                return Ok(Some(motion));
            }
            motion.series = motion.series.map(|series| series.scaled(SMALLER));
        }
        Ok(None)
    }

    /// Joint motion at `t`, s from its beginning.
    pub fn at(&self, t: f64) -> Motion {
        let values = self.series.map(|series| series.at(t));
        Motion {
            zeta: values.map(|[angle, ..]| angle),
            zeta_dot: values.map(|[_, rate, _]| rate),
            zeta_ddot: values.map(|[.., acceleration]| acceleration),
        }
    }

    /// The path of the tip, as a path file.
    pub fn path(&self, machine: &Machine) -> Result<String> {
        let kinematics = Kinematics::new(machine)?;
        let sample = |t: f64| {
            let pose = kinematics.pose(&self.at(t).zeta);
            let ([x, y, z], q) = (pose.position.into(), pose.orientation);
            json!([t, x, y, z, q.w, q.i, q.j, q.k])
        };
        let samples: Vec<_> = times(STEP).map(sample).collect();
        Ok(json!({ "samples": samples }).to_string())
    }

    /// Whether the nominal machine can follow it: for so short a time the torque may exceed what it
    /// may be continuously.
    fn is_possible(&self, machine: &Machine) -> Result<bool> {
        let file = PathFile::parse(&self.path(machine)?)?;
        let zeta = machine.start.zeta;
        let path = TipPath::new(&file, Kinematics::new(machine)?.pose(&zeta))?;
        let long = path.duration();
        ensure!((long - DURATION).abs() < 1e-6, "the path takes {long} s");
        let found = check(&file, &path, machine, &zeta, |_, _| ())?.findings;
        Ok(found.iter().all(|f| matches!(f, Finding::Torque { .. })))
    }
}

/// Times from the beginning to the end.
fn times(step: f64) -> impl Iterator<Item = f64> {
    let count = (DURATION / step).round() as u32;
    (0..=count).map(move |k| DURATION * f64::from(k) / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rates and accelerations are derivatives, by central differences; at both ends the machine
    /// rests in its start pose; the joints move, and the rods stay below their rated speed.
    #[test]
    fn it_begins_and_ends_at_rest_and_moves_all_joints() {
        let model = Model::new(&Machine::reference()).expect("a machine");
        let motion = Excitation::best(&model).expect("a motion");
        for t in [0.0, DURATION] {
            let Motion {
                zeta,
                zeta_dot,
                zeta_ddot,
            } = motion.at(t);
            for k in 0..DOF {
                assert!((zeta[k] - model.machine.start.zeta[k]).abs() < 1e-12);
                assert!(zeta_dot[k].abs() < 1e-12 && zeta_ddot[k].abs() < 1e-11);
            }
        }
        // Third derivatives are below (2π·0.5 Hz)²·1 rad/s = 10, times h²/6.
        let (t, h) = (7.3, 1e-4);
        let [before, now, after] = [t - h, t, t + h].map(|t| motion.at(t));
        for k in 0..DOF {
            let rate = (after.zeta[k] - before.zeta[k]) / (2.0 * h);
            let acceleration = (after.zeta_dot[k] - before.zeta_dot[k]) / (2.0 * h);
            assert!((rate - now.zeta_dot[k]).abs() < 1e-6);
            assert!((acceleration - now.zeta_ddot[k]).abs() < 1e-6);
            let ways = times(STEP).map(|t| (motion.at(t).zeta[k] - now.zeta[k]).abs());
            assert!(ways.fold(0.0, f64::max) > 0.1, "joint {k} rests");
        }
        assert!(motion.condition.number < 1e3, "{:?}", motion.condition);
    }
}
