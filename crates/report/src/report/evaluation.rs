//! Testbed and energy balances as the page takes them.

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;

use super::failures::kept;
use super::request::Request;
use super::samples::Samples;
use studies::grid::TRAJECTORIES;
use studies::measures::energy;
use studies::start_values::vary;
use studies::studies::testbed::{self, CHECK, Replay};

/// Time constant of the testbed's load emulators, s.
const LAG: f64 = 0.02;
/// Sampling of the testbed's curves, s.
const EVERY: f64 = 0.02;

/// The one-axis experiment.
#[derive(Serialize)]
pub struct Testbed {
    /// Time constant of the load emulators, s.
    lag: f64,
    pub axes: Vec<Axis>,
}

/// One axis on one trajectory: numbers and curves, desired and actual.
#[derive(Serialize)]
pub struct Axis {
    #[serde(flatten)]
    pub numbers: testbed::Axis,
    start: f64,
    every: f64,
    /// Number of samples.
    count: usize,
    pub curves: Curves,
}

/// Desired and actual course.
#[derive(Serialize)]
pub struct Curves {
    pub position: [Samples; 2],
    pub velocity: [Samples; 2],
    pub force: [Samples; 2],
}

/// Energy balances of one trajectory.
#[derive(Serialize)]
pub struct Energy {
    trajectory: &'static str,
    balances: Vec<Balance>,
}

#[derive(Serialize)]
struct Balance {
    #[serde(flatten)]
    energies: energy::Balance,
    efficiency: Option<f64>,
    throughput: f64,
}

/// Runs that [`energies`] makes.
pub const RUNS: u64 = TRAJECTORIES.len() as u64;

/// The one-axis experiment where there is a testbed; what failed of it goes to `failures`.
pub fn testbed(request: &Request<'_>, failures: &mut Vec<String>) -> Option<Testbed> {
    let bed = request.testbed?;
    let (machine, base) = (request.system, request.base);
    let axes = testbed::record(machine, base).and_then(|runs| {
        let replay = Replay {
            machine,
            base,
            runs: &runs,
            lag: LAG,
        };
        replay.on(bed, &[CHECK])
    });
    let axes = axes.map_err(|error| failures.push(format!("testbed: {error:#}")));
    let axes = axes.unwrap_or_default().into_iter().map(Axis::new);
    Some(Testbed {
        lag: LAG,
        axes: axes.collect(),
    })
}

impl Axis {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive number"
    )]
    fn new(numbers: testbed::Axis) -> Self {
        let course = &numbers.course;
        let start = course.time.first().copied().unwrap_or(0.0);
        let step = course.time.get(1).map_or(EVERY, |t| t - start);
        let stride = ((EVERY / step).round() as usize).max(1);
        let thinned = |pair: &[Vec<f64>; 2]| {
            [0, 1].map(|k| Samples::new(pair[k].iter().step_by(stride).copied()))
        };
        Self {
            start,
            every: stride as f64 * step,
            count: course.time.len().div_ceil(stride),
            curves: Curves {
                position: thinned(&course.position),
                velocity: thinned(&course.velocity),
                force: thinned(&course.force),
            },
            numbers,
        }
    }

    /// Times, s, and values times `factor`.
    pub fn points(&self, samples: &Samples, factor: f64) -> Vec<(f64, f64)> {
        let at = |k: usize| self.start + k as f64 * self.every;
        let points = samples.values().enumerate();
        points.map(|(k, v)| (at(k), factor * v)).collect()
    }
}

/// Energy balances of the adaptive controller's runs.
pub fn energies(
    request: &Request<'_>,
    done: impl Fn() + Sync,
    failures: &mut Vec<String>,
) -> Vec<Energy> {
    let one = |trajectory| -> Result<Energy> {
        let experiment = vary(request.system, request.base, &[("trajectory", &trajectory)])?;
        let energies = energy::run(request.system, &experiment);
        done();
        let balances = energies
            .with_context(|| format!("energy, {trajectory}"))?
            .balances;
        let balance = |energies: energy::Balance| Balance {
            efficiency: energies.efficiency(),
            throughput: energies.throughput(),
            energies,
        };
        Ok(Energy {
            trajectory,
            balances: balances.into_iter().map(balance).collect(),
        })
    };
    let results: Vec<_> = TRAJECTORIES.into_par_iter().map(one).collect();
    kept(results, failures)
}
