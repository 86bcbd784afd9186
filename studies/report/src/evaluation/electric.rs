//! The machine fed by a battery as the page takes it: where the energy goes, the link over time,
//! motors under their envelopes.

use std::f64::consts::TAU;

use anyhow::{Context, Result};
use cosim::{Experiment, Port, System};
use serde_json::{Value, json};

use super::request::{Request, kept, kept_as};
use super::runs::stride;
use super::samples::{SampleTimes, Samples};
use experiments::analyses::sizing;
use experiments::measures::energy;
use experiments::measures::run::RecordedRun;
use experiments::measures::supply::{self, Supply};

/// Sampling of the page, s.
const EVERY: f64 = 0.02;
/// Signals of every actuator, as far as it has them.
const OF_ACTUATOR: [&str; 3] = ["i_dc_mean", "T_winding", "T_housing"];

/// Both trajectories; what failed of them goes to `failures`.
pub fn shown(request: &Request, failures: &mut Vec<String>) -> Vec<Value> {
    let Some(system) = request.electric else {
        return Vec::new();
    };
    let cases = energy::trajectory_cases(system, &request.elsewhere());
    let cases = kept_as("electric", cases, failures).unwrap_or_default();
    let of = |(case, experiment): (String, Experiment)| {
        one(system, &case, &experiment).with_context(|| format!("electric, {case}"))
    };
    kept(cases.into_iter().map(of).collect(), failures)
}

fn one(system: &System, case: &str, experiment: &Experiment) -> Result<Value> {
    let mut ports: Vec<Port> = Vec::new();
    let mut of = |k: usize, names: &[&str]| {
        ports.extend(names.iter().filter_map(|name| system.port_of(k, name).ok()));
    };
    if let Some(k) = supply::component(system)? {
        of(k, &supply::SHOWN);
    }
    for k in energy::actuators(system) {
        of(k, &OF_ACTUATOR);
    }
    let all = [&ports[..], &energy::ports(system)?, &sizing::ports(system)?].concat();
    let recorded = RecordedRun::record(system, experiment, &all)?;
    let times = &recorded.recording.times;
    let start = times.first().copied().unwrap_or(0.0);
    let step = experiment.stepping.step;
    let stride = stride(EVERY, step);
    let mut curves = Vec::new();
    for port in ports {
        let samples = Samples::thinned(recorded.recording.column(port)?, stride);
        curves.push(json!({"name": system.name(port), "samples": samples}));
    }
    let supply = energy::evaluate(system, &recorded)?.supply;
    let sizing = sizing::evaluate(system, experiment, &recorded)?;
    let mut shown = json!(SampleTimes::thinned(start, step, times.len(), stride));
    shown["trajectory"] = case.into();
    shown["open"] = json!(supply.as_ref().map(Supply::open));
    shown["supply"] = json!(supply);
    shown["curves"] = curves.into();
    shown["motors"] = sizing.axes.iter().map(motor).collect();
    shown["sizing"] = json!(sizing);
    Ok(shown)
}

/// Torque over speed, rev/min, of one actuator: points of the motion, and its envelopes.
fn motor(axis: &sizing::Axis) -> Value {
    let rpm = 60.0 / TAU;
    let fastest = (axis.ratings.motor_speed_rpm / rpm).max(axis.speed.peak);
    let speeds = || (0..=100).map(|k| f64::from(k) * fastest / 100.0);
    json!({
        "actuator": axis.actuator,
        "count": axis.points.len(),
        "motion": [
            Samples::new(axis.points.iter().map(|(w, _)| rpm * w)),
            Samples::new(axis.points.iter().map(|(_, tau)| *tau)),
        ],
        "speeds": Samples::new(speeds().map(|w| rpm * w)),
        "peak": Samples::new(speeds().map(|w| axis.motor.peak(w))),
        "continuous": Samples::new(speeds().map(|w| axis.motor.continuous(w, &axis.ratings))),
    })
}
