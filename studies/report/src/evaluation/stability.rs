//! The report's section on the stability proof, and the data of its figure: the numbers that
//! `hdrm-fmu stability` prints, and the accompanying functions and powers over time.

use std::collections::BTreeMap;

use anyhow::Result;
use serde::Serialize;
use serde_json::{Value, json};

use super::request::{Request, UNCERTAIN, successes};
use super::samples::{EVERY, SampleTimes, Samples, stride};
use experiments::analyses::stability::{self, Condition, Gains, Powers};

/// Runs, and the gain conditions that they share.
#[derive(Serialize)]
pub struct Stability {
    /// Inertias of the machine over those that the controller assumes.
    inertia_scale: f64,
    pub runs: Vec<Run>,
    gains: Option<Gains>,
    conditions: Vec<Value>,
}

#[derive(Serialize)]
pub struct Run {
    #[serde(flatten)]
    pub numbers: stability::Run,
    #[serde(flatten)]
    pub times: SampleTimes,
    pub curves: Curves,
}

/// Accompanying functions, J, and powers, W, by name. A power's sample is the mean since the sample
/// before; that of `excess_max` is the largest value.
type Curves = BTreeMap<&'static str, Samples>;

/// Makes the runs; a failed one goes to `failures`.
pub fn results(
    request: &Request<'_>,
    done: impl Fn() + Sync,
    failures: &mut Vec<String>,
) -> Result<Stability> {
    let (results, _) = stability::run(request.system, request.base, UNCERTAIN, done)?;
    let runs = successes(results, failures);
    let gains = runs.first().map(|run| run.gains);
    let verdict = |condition: Condition| {
        let mut json = json!(condition);
        json["holds"] = condition.holds().into();
        json
    };
    let conditions = gains.iter().flat_map(Gains::conditions);
    Ok(Stability {
        inertia_scale: UNCERTAIN,
        runs: runs.into_iter().map(Run::new).collect(),
        gains,
        conditions: conditions.map(verdict).collect(),
    })
}

impl Run {
    fn new(numbers: stability::Run) -> Self {
        let stride = stride(EVERY, numbers.step);
        let course = &numbers.course;
        let count = course.nu_dot.len() / stride;
        Self {
            times: SampleTimes {
                start: course.start,
                every: stride as f64 * numbers.step,
                count,
            },
            curves: curves(course, stride, count),
            numbers,
        }
    }
}

fn curves(course: &Powers, stride: usize, count: usize) -> Curves {
    let point = |values: &[f64]| Samples::new(values.iter().step_by(stride).take(count).copied());
    let mean = |values: &[f64]| {
        let parts = values.chunks_exact(stride);
        Samples::new(parts.map(|part| part.iter().sum::<f64>() / stride as f64))
    };
    let excess = course.excess();
    let largest = |part: &[f64]| part.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Curves::from([
        ("nu_velocity", point(&course.nu_velocity)),
        ("nu_adaptation", point(&course.nu_adaptation)),
        ("nu_actuators", point(&course.nu_actuators)),
        ("nu_dot", mean(&course.nu_dot)),
        ("dissipation", mean(&course.dissipation)),
        ("bodies", mean(&course.bodies)),
        ("actuators", mean(&course.actuators)),
        ("cuts", mean(&course.cuts)),
        (
            "excess_max",
            Samples::new(excess.chunks_exact(stride).map(largest)),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A peak between two samples is seen in the largest value, a power that cancels leaves no
    /// mean.
    #[test]
    fn no_peak_is_lost_between_samples() {
        let course = Powers {
            nu_velocity: vec![1.0, 2.0, 3.0, 4.0, 5.0],
            bodies: vec![0.0, 7.0, -7.0, 1.0],
            actuators: vec![0.0; 4],
            cuts: vec![0.0; 4],
            nu_dot: vec![3.0, 5.0, 0.0, 0.0],
            ..Powers::default()
        };
        let curves = curves(&course, 2, 2);
        let values = |name: &str| curves[name].values().collect::<Vec<_>>();
        assert_eq!(values("excess_max"), [7.0, 1.0]);
        assert_eq!(values("bodies"), [3.5, -3.0]);
        assert_eq!(values("nu_dot"), [4.0, 0.0]);
        assert_eq!(values("nu_velocity"), [1.0, 3.0]);
    }
}
