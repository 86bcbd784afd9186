//! The report's section on the testbed, and the data of its figures: one actuator at a time replays
//! the loads that a run of the machine put on it.

use std::collections::BTreeMap;

use anyhow::{Context as _, Result};
use serde::Serialize;

use super::request::{Request, success, successes};
use super::samples::{EVERY, SampleTimes, Samples, stride};
use experiments::analyses::testbed::{self, CHECK, MachineRun, Replay};

/// Time constant of the testbed's load emulators, s.
const LAG: f64 = 0.02;

#[derive(Serialize)]
pub struct Testbed {
    /// Time constant of the load emulators, s.
    lag: f64,
    pub axes: Vec<Axis>,
}

/// One axis on one trajectory, with its curves.
#[derive(Serialize)]
pub struct Axis {
    #[serde(flatten)]
    pub numbers: testbed::Axis,
    #[serde(flatten)]
    pub times: SampleTimes,
    /// Desired and actual position, velocity and force.
    pub curves: BTreeMap<&'static str, [Samples; 2]>,
}

/// Replays the loads of `machine_runs`, if there is a testbed; a failure goes to `failures`.
pub fn results(
    request: &Request<'_>,
    machine_runs: Vec<Result<MachineRun>>,
    failures: &mut Vec<String>,
) -> Option<Testbed> {
    let bed = request.testbed?;
    let runs = successes(machine_runs, failures);
    let replay = Replay {
        machine: request.system,
        base: request.base,
        runs: &runs,
        lag: LAG,
    };
    let axes = replay.on(bed, &[CHECK]).context("testbed");
    let axes = success(axes, failures).into_iter().flatten();
    let axes = axes.map(Axis::new).collect();
    Some(Testbed { lag: LAG, axes })
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
