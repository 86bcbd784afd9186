//! The report's section on the surrogate on the rig: efficiency maps, time responses, and coupled
//! runs of the machine with it. `Report::new` makes it.

use anyhow::{Context as _, Result};
use cosim::{Experiment, System};
use serde_json::{Value, json};
use surrogate::measurement::campaign::{held_out_profiles, measure};
use surrogate::measurement::profile::{Kind, LOAD_MAX, SPEED};
use surrogate::prediction::efficiency_map::{EfficiencyMap, maps};
use surrogate::prediction::responses::responses;

use super::request::{Request, success};
use super::samples::Samples;
use experiments::analyses::surrogate_loop::{self, RigNetwork, SurrogateRun};
use experiments::runs::grid::Case;

/// Cells of the maps along load and along speed.
const CELLS: [usize; 2] = [28, 56];
/// Length of the held-out profile, s.
const SECONDS: f64 = 10.0;
/// Every how many communication points a current is drawn: 20 ms.
const STRIDE: usize = 20;

/// The results on the machine of the real world, if its system is at hand; a failure goes to
/// `failures`.
pub fn results(request: &Request<'_>, failures: &mut Vec<String>) -> Option<Value> {
    let result = evaluate(request.real?, &request.elsewhere());
    success(result.context("surrogate on the rig"), failures)
}

/// The maps with their largest load, N, and speed, m/s, either way, and cells; responses; runs.
fn evaluate(system: &System, base: &Experiment) -> Result<Value> {
    let network = RigNetwork::new()?;
    let map = |map: EfficiencyMap| {
        let values = Samples::new(map.cells.into_iter().flatten());
        json!({"title": map.title, "values": values})
    };
    let mut work = held_out_profiles(6, SECONDS, 1);
    work.retain(|profile| profile.kind == Kind::Work);
    let p = machine_file::Machine::reference().emla.lift;
    let measured = measure(&p, &work[..1], |profile| profile.seed)?;
    let panels = responses(&network.network, &measured[0]).into_iter();
    let panels = panels.map(|panel| {
        let lines: Vec<_> = panel.lines.into_iter().map(line).collect();
        json!({"title": panel.title, "unit": panel.unit, "lines": lines})
    });
    let nominal = [Case::new("nominal", Vec::new())];
    let (runs, _) = surrogate_loop::run(system, base, &network, &nominal, || ())?;
    Ok(json!({
        "maps": maps(&network.models(), CELLS)?.map(map),
        "reach": [LOAD_MAX, SPEED[1]],
        "cells": CELLS,
        "responses": panels.collect::<Vec<_>>(),
        "runs": runs.iter().map(run).collect::<Vec<_>>(),
    }))
}

fn line((name, points): (&'static str, Vec<(f64, f64)>)) -> Value {
    let [t, y] = [0, 1].map(|k| Samples::new(points.iter().map(|p| [p.0, p.1][k])));
    json!({"name": name, "t": t, "y": y})
}

/// The numbers of a run. Of the lift axis: times, required and true current; and times, true
/// efficiency, and that of physics, hybrid and network.
fn run(run: &SurrogateRun) -> Value {
    let (current, efficiency) = (&run.lift_current, &run.lift_efficiency);
    let current = |k: usize| Samples::new(current[k].iter().step_by(STRIDE).copied());
    let efficiency = |k: usize| Samples::new(efficiency.iter().map(|row| row[k]));
    let mut json = json!(run);
    json["lift_current"] = json!([0, 1, 2].map(current));
    json["lift_efficiency"] = json!([0, 1, 2, 3, 4].map(efficiency));
    json
}
