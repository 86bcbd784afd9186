//! The one-axis experiment as the page takes it.

use std::collections::BTreeMap;

use anyhow::Result;
use serde::Serialize;

use super::request::{Request, kept, kept_as};
use super::runs::stride;
use super::samples::{SampleTimes, Samples};
use experiments::analyses::testbed::{self, CHECK, MachineRun, Replay};

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
    #[serde(flatten)]
    pub times: SampleTimes,
    /// Desired and actual position, velocity and force.
    pub curves: BTreeMap<&'static str, [Samples; 2]>,
}

/// The one-axis experiment, where there is a testbed, of these runs of the machine; what failed of
/// it goes to `failures`.
pub fn replayed(
    request: &Request<'_>,
    machines: Vec<Result<MachineRun>>,
    failures: &mut Vec<String>,
) -> Option<Testbed> {
    let bed = request.testbed?;
    let runs = kept(machines, failures);
    let replay = Replay {
        machine: request.system,
        base: request.base,
        runs: &runs,
        lag: LAG,
    };
    let axes = replay.on(bed, &[CHECK]);
    let axes = kept_as("testbed", axes, failures).unwrap_or_default();
    Some(Testbed {
        lag: LAG,
        axes: axes.into_iter().map(Axis::new).collect(),
    })
}

impl Axis {
    fn new(numbers: testbed::Axis) -> Self {
        let course = &numbers.course;
        let start = course.time.first().copied().unwrap_or(0.0);
        let step = course.time.get(1).map_or(EVERY, |t| t - start);
        let stride = stride(EVERY, step);
        let thinned = |pair: &[Vec<f64>; 2]| pair.each_ref().map(|c| Samples::thinned(c, stride));
        Self {
            times: SampleTimes::thinned(start, step, course.time.len(), stride),
            curves: BTreeMap::from([
                ("position", thinned(&course.position)),
                ("velocity", thinned(&course.velocity)),
                ("force", thinned(&course.force)),
            ]),
            numbers,
        }
    }
}
