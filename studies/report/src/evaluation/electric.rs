//! The report's section on the machine fed by a battery: where the energy goes, the DC link over
//! time, and the motors' torque under their envelopes. `Report::new` makes it.

use std::f64::consts::TAU;

use anyhow::{Context, Result};
use cosim::{Experiment, Port, System};
use serde_json::{Value, json};

use super::request::{Request, success, successes};
use super::samples::{EVERY, SampleTimes, Samples, stride};
use experiments::analyses::sizing;
use experiments::measures::energy;
use experiments::measures::run::RecordedRun;
use experiments::measures::supply::{self, Supply};

/// Signals of an actuator, as far as it has them.
const ACTUATOR_SIGNALS: [&str; 3] = ["i_dc_mean", "T_winding", "T_housing"];

/// The results of both trajectories; a failed run goes to `failures`.
pub fn results(request: &Request, failures: &mut Vec<String>) -> Vec<Value> {
    let Some(system) = request.electric else {
        return Vec::new();
    };
    let cases = energy::trajectory_cases(system, &request.elsewhere()).context("electric");
    let cases = success(cases, failures).unwrap_or_default();
    let evaluate = |(case, experiment): (String, Experiment)| {
        evaluate(system, &case, &experiment).with_context(|| format!("electric, {case}"))
    };
    successes(cases.into_iter().map(evaluate), failures)
}

fn evaluate(system: &System, case: &str, experiment: &Experiment) -> Result<Value> {
    let mut ports: Vec<Port> = Vec::new();
    let mut add_ports = |k: usize, names: &[&str]| {
        ports.extend(names.iter().filter_map(|name| system.port_of(k, name).ok()));
    };
    if let Some(k) = supply::component(system)? {
        add_ports(k, &supply::SHOWN);
    }
    for k in energy::actuators(system) {
        add_ports(k, &ACTUATOR_SIGNALS);
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
    let mut result = json!(SampleTimes::thinned(start, step, times.len(), stride));
    result["trajectory"] = case.into();
    result["open"] = json!(supply.as_ref().map(Supply::open));
    result["supply"] = json!(supply);
    result["curves"] = curves.into();
    result["motors"] = sizing.axes.iter().map(motor).collect();
    result["sizing"] = json!(sizing);
    Ok(result)
}

/// Torque over speed, rev/min, of one actuator: the motion's points, and the motor's envelopes.
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
