//! The surrogate on the rig as the page takes it: efficiency maps, time responses, and what it does
//! in the loop.

use anyhow::Result;
use cosim::run::Experiment;
use cosim::system::System;
use rig_data::campaign::{held_out_profiles, measure};
use rig_data::efficiency_map::{self, maps};
use rig_data::profile::{Kind, LOAD_MAX, SPEED};
use rig_data::responses::responses;
use serde::Serialize;

use super::request::{Request, kept_as};
use super::samples::Samples;
use studies::grid::Case;
use studies::studies::surrogate_loop::{self, LiftCourse, RigNetwork, SurrogateRun};

/// Cells of the maps along load and along speed.
const CELLS: [usize; 2] = [28, 56];
/// Length of the held-out profile, s.
const SECONDS: f64 = 10.0;
/// Every how many communication points a current is drawn: 20 ms.
const STRIDE: usize = 20;

/// The section of the page.
#[derive(Serialize)]
pub struct RigComparison {
    maps: Vec<Map>,
    /// Largest load, N, and speed, m/s, of the maps, either way.
    reach: [f64; 2],
    cells: [usize; 2],
    responses: Vec<Panel>,
    runs: Vec<Run>,
}

#[derive(Serialize)]
struct Map {
    title: String,
    /// Row by row of load.
    values: Samples,
}

#[derive(Serialize)]
struct Panel {
    title: &'static str,
    unit: &'static str,
    lines: Vec<Line>,
}

#[derive(Serialize)]
struct Line {
    name: &'static str,
    t: Samples,
    y: Samples,
}

#[derive(Serialize)]
struct Run {
    #[serde(flatten)]
    numbers: SurrogateRun,
    /// Times, required and true current.
    lift_current: [Samples; 3],
    /// Times, true efficiency, that of physics, hybrid and network.
    lift_efficiency: [Samples; 5],
}

/// Of the machine of the real world, where its system is at hand; what failed goes to `failures`.
pub fn on_rig(request: &Request<'_>, failures: &mut Vec<String>) -> Option<RigComparison> {
    let system = request.real?;
    let made = made(system, &request.elsewhere());
    kept_as("surrogate on the rig", made, failures)
}

fn made(system: &System, base: &Experiment) -> Result<RigComparison> {
    let network = RigNetwork::new()?;
    let map = |map: efficiency_map::EfficiencyMap| Map {
        title: map.title,
        values: Samples::new(map.cells.into_iter().flatten()),
    };
    let mut work = held_out_profiles(6, SECONDS, 1);
    work.retain(|profile| profile.kind == Kind::Work);
    let p = machine::Machine::reference().emla.lift;
    let measured = measure(&p, &work[..1], |profile| profile.seed)?;
    let panels = responses(&network.network, &measured[0]).into_iter();
    let panels = panels.map(|panel| Panel {
        title: panel.title,
        unit: panel.unit,
        lines: panel.lines.into_iter().map(line).collect(),
    });
    let nominal = [Case::new("nominal", Vec::new())];
    let (runs, _) = surrogate_loop::run(system, base, &network, &nominal, || ())?;
    Ok(RigComparison {
        maps: maps(&network.models(), CELLS)?.map(map).into(),
        reach: [LOAD_MAX, SPEED[1]],
        cells: CELLS,
        responses: panels.collect(),
        runs: runs.into_iter().map(Run::from).collect(),
    })
}

fn line((name, points): (&'static str, Vec<(f64, f64)>)) -> Line {
    Line {
        name,
        t: Samples::new(points.iter().map(|p| p.0)),
        y: Samples::new(points.iter().map(|p| p.1)),
    }
}

impl From<SurrogateRun> for Run {
    fn from(mut numbers: SurrogateRun) -> Self {
        let LiftCourse {
            current,
            efficiency,
        } = std::mem::take(&mut numbers.lift);
        Self {
            numbers,
            lift_current: current.map(|c| Samples::new(c.into_iter().step_by(STRIDE))),
            lift_efficiency: [0, 1, 2, 3, 4]
                .map(|k: usize| Samples::new(efficiency.iter().map(|row| row[k]))),
        }
    }
}
