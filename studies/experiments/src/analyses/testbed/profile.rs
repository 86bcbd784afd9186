//! The rods' motions and forces in runs of the machine, for the testbed's replays and the report.
#![allow(non_snake_case)] // the paper's symbols

use anyhow::{Context, Result, ensure};
use cosim::{Experiment, Port, System, Verdict};
use rayon::prelude::*;

use super::axis::AXES;
use crate::measures::run::RecordedRun;
use crate::runs::grid::TRAJECTORIES;
use crate::setup::start_values::vary;

/// Course of one rod in a run of the whole machine, at the communication points.
pub(super) struct Profile {
    /// Position, m.
    pub x: Vec<f64>,
    /// Velocity, m/s.
    pub x_dot: Vec<f64>,
    /// Acceleration, m/s², by central differences of the velocity.
    x_ddot: Vec<f64>,
    /// Force of the actuator, N.
    pub F: Vec<f64>,
}

/// A run of the whole machine on a trajectory.
pub struct MachineRun {
    pub(super) trajectory: &'static str,
    /// Courses of the rods of both axes.
    pub(super) profiles: [Profile; 2],
    /// Index of the first communication point of the motion.
    pub(super) motion_start: usize,
    /// The verdict on the run.
    pub verdict: Verdict,
}

impl Profile {
    /// Position, velocity, acceleration and force at this share of the way from point `k` to the
    /// next.
    pub(super) fn between(&self, k: usize, share: f64) -> [f64; 4] {
        let next = (k + 1).min(self.x.len() - 1);
        [&self.x, &self.x_dot, &self.x_ddot, &self.F]
            .map(|course| course[k] + share * (course[next] - course[k]))
    }
}

/// Runs the `machine` under `base` on both trajectories.
pub(crate) fn record(machine: &System, base: &Experiment) -> Result<Vec<MachineRun>> {
    let ports = ports(machine)?;
    let one = |trajectory: &'static str| {
        let experiment = vary(machine, base, &[("trajectory", &trajectory)])?;
        RecordedRun::record(machine, &experiment, &ports)
            .and_then(|recorded| {
                MachineRun::new(machine, trajectory, base.stepping.step, &recorded)
            })
            .with_context(|| format!("{trajectory}, run of the machine"))
    };
    TRAJECTORIES.into_par_iter().map(one).collect()
}

/// What must be recorded of the machine at every communication point. Fails if it does not have the
/// rods of the testbed.
pub fn ports(machine: &System) -> Result<Vec<Port>> {
    Ok(rods(machine)?.as_flattened().to_vec())
}

impl MachineRun {
    /// From a recorded run of the machine on this trajectory in communication steps of `step`, s.
    /// Fails if it is too short to be replayed, or one of [`ports`] was not recorded.
    pub fn new(
        machine: &System,
        trajectory: &'static str,
        step: f64,
        recorded: &RecordedRun,
    ) -> Result<Self> {
        let times = &recorded.recording.times;
        ensure!(times.len() > 1, "the recording is empty");
        let profile = |[x, x_dot, force]: [Port; 3]| -> Result<Profile> {
            let column = |port| recorded.recording.column(port).map(<[f64]>::to_vec);
            let x_dot = column(x_dot)?;
            Ok(Profile {
                x: column(x)?,
                x_ddot: slope(&x_dot, step),
                x_dot,
                F: column(force)?,
            })
        };
        let [lift, tilt] = rods(machine)?;
        Ok(Self {
            trajectory,
            profiles: [profile(lift)?, profile(tilt)?],
            motion_start: recorded.motion_start(),
            verdict: recorded.outcome.verdict(),
        })
    }
}

/// Position, velocity and force of the machine's rod of each axis.
pub(super) fn rods(machine: &System) -> Result<[[Port; 3]; 2]> {
    let arm = machine.port("f_hold[1]")?.component;
    let wiring = machine.wiring()?;
    let [lift, tilt] = AXES.map(|(_, rod, _)| {
        let port = |array: &str| machine.port_of(arm, &format!("{array}[{rod}]"));
        let force = wiring.driver(port("f")?);
        let force = force.with_context(|| format!("nothing drives rod {rod}"))?;
        anyhow::Ok([port("x")?, port("x_dot")?, wiring.links[force].from])
    });
    Ok([lift?, tilt?])
}

/// Derivative by central differences, one-sided at the ends.
fn slope(values: &[f64], step: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let at = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        (values[after] - values[before]) / (step * (after - before).max(1) as f64)
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quadratic: central differences are exact inside, half a step off at the ends.
    #[test]
    fn slopes_of_a_parabola() {
        let values: Vec<f64> = (0..5).map(|k| f64::from(k * k)).collect();
        assert_eq!(slope(&values, 1.0), [1.0, 2.0, 4.0, 6.0, 7.0]);
    }
}
