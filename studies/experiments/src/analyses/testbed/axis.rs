//! The axes of the testbed, the controllers on it, and what is measured of an axis.

use anyhow::Result;
use cosim::{Inputs, Port, System};
use serde::Serialize;

use crate::measures::run::Distance;

/// An axis of the testbed: name, number of its rod, component of the testbed.
pub(super) const AXES: [(&str, usize, &str); 2] =
    [("lift", 2, "emla_lift"), ("tilt", 3, "emla_tilt")];
/// Component of the testbed that controls both.
pub(super) const CONTROLLER: &str = "controller";

pub(super) fn inputs(testbed: &System, names: &[String]) -> Result<Inputs> {
    Inputs::new(testbed, &ports(testbed, names)?)
}

pub(super) fn ports(system: &System, names: &[String]) -> Result<Vec<Port>> {
    names.iter().map(|name| system.port(name)).collect()
}

/// Position RMSE to stay below, m.
pub const POSITION_TARGET: f64 = 0.05e-3;
/// Force RMSE to stay below, as a share of the force's peak.
pub const FORCE_TARGET: f64 = 0.01;

/// A controller on the testbed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TestedLaw {
    /// Mode of the controller.
    pub mode: &'static str,
    /// Whether it is told the load's force beforehand.
    pub previewed: bool,
}

/// What checks the code: the controller is told the load.
pub const CHECK: TestedLaw = TestedLaw {
    mode: "adaptive",
    previewed: true,
};

/// The load is not known beforehand.
pub const UNKNOWN_LOAD: [TestedLaw; 5] = {
    const fn untold(mode: &'static str) -> TestedLaw {
        let previewed = false;
        TestedLaw { mode, previewed }
    }
    [
        untold("adaptive"),
        untold("modular"),
        untold("pd"),
        untold("modular_integral"),
        untold("pd_integral"),
    ]
};

/// What loads an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Load {
    /// A force with a first-order lag.
    Emulator,
    /// A second rig under force control.
    Rig,
}

/// An axis under a load.
#[derive(Clone, Debug, Serialize)]
pub struct LoadedAxis {
    /// What loaded it.
    pub load: Load,
    /// The axis.
    #[serde(flatten)]
    pub axis: Axis,
}

/// Root mean square and maximum of an error, and the peak of what was to be followed.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct AxisError {
    /// Root mean square error.
    pub rmse: f64,
    /// Largest error.
    pub max: f64,
    /// Largest magnitude of the reference.
    pub peak: f64,
}

/// Result of one axis on one trajectory.
#[derive(Clone, Debug, Serialize)]
pub struct Axis {
    /// Trajectory.
    pub trajectory: &'static str,
    /// `lift` or `tilt`.
    pub axis: &'static str,
    /// The controller.
    #[serde(rename = "trial")]
    pub law: TestedLaw,
    /// Position, m.
    pub position: AxisError,
    /// Velocity, m/s.
    pub velocity: AxisError,
    /// Force on the load, N.
    pub force: AxisError,
    /// Course over time.
    #[serde(skip)]
    pub course: Course,
}

/// Reference and measurement of one axis at the communication points.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// Time, s.
    pub time: Vec<f64>,
    /// Desired and actual position, m.
    pub position: [Vec<f64>; 2],
    /// Desired and actual velocity, m/s.
    pub velocity: [Vec<f64>; 2],
    /// Desired and actual force on the load, N.
    pub force: [Vec<f64>; 2],
}

impl Course {
    pub(super) fn add(&mut self, time: f64, desired: [f64; 3], actual: &[f64]) {
        self.time.push(time);
        let columns = [&mut self.position, &mut self.velocity, &mut self.force];
        for ((column, desired), actual) in columns.into_iter().zip(desired).zip(actual) {
            column[0].push(desired);
            column[1].push(*actual);
        }
    }
}

impl Axis {
    /// The errors of a course from sample `first` on.
    pub(super) fn of(
        trajectory: &'static str,
        axis: &'static str,
        law: TestedLaw,
        course: Course,
        first: usize,
    ) -> Self {
        Self {
            trajectory,
            axis,
            law,
            position: error(&course.position, first),
            velocity: error(&course.velocity, first),
            force: error(&course.force, first),
            course,
        }
    }

    /// Whether its position is as near as it should be.
    pub fn meets_position_target(&self) -> bool {
        self.position.rmse <= POSITION_TARGET
    }

    /// Whether its force is as near as it should be.
    pub fn meets_force_target(&self) -> bool {
        self.force.rmse <= FORCE_TARGET * self.force.peak
    }
}

/// Errors from sample `first` on.
fn error([desired, actual]: &[Vec<f64>; 2], first: usize) -> AxisError {
    let (mut error, mut peak) = (Distance::default(), 0.0_f64);
    for (d, a) in desired.iter().zip(actual).skip(first) {
        error.add((d - a).abs());
        peak = peak.max(d.abs());
    }
    AxisError {
        rmse: error.rms(),
        max: error.max,
        peak,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_count_from_the_first_sample_of_the_motion() {
        let courses = [vec![9.0, 1.0, -2.0], vec![0.0, 4.0, 2.0]];
        let t = error(&courses, 1);
        assert_eq!((t.rmse, t.max, t.peak), (12.5f64.sqrt(), 4.0, 2.0));
    }
}
