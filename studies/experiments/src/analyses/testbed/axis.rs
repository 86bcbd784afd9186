//! The axes of the testbed, the control laws that are tested on it, and the measured errors of an
//! axis: for the testbed's other files, the subcommand `testbed` and the report.

use anyhow::Result;
use cosim::{Inputs, Port, System};
use serde::Serialize;

use crate::measures::run::Distance;

/// The axes: name, number of the rod on the machine, component of the testbed.
pub(super) const AXES: [(&str, usize, &str); 2] =
    [("lift", 2, "emla_lift"), ("tilt", 3, "emla_tilt")];
/// Component of the testbed that controls both axes.
pub(super) const CONTROLLER: &str = "controller";

pub(super) fn inputs(testbed: &System, names: &[String]) -> Result<Inputs> {
    Inputs::new(testbed, &ports(testbed, names)?)
}

pub(super) fn ports(system: &System, names: &[String]) -> Result<Vec<Port>> {
    names.iter().map(|name| system.port(name)).collect()
}

/// Largest position RMSE that meets the target, m.
pub(crate) const POSITION_TARGET: f64 = 0.05e-3;
/// Largest force RMSE that meets the target, as a share of the force's peak.
pub(crate) const FORCE_TARGET: f64 = 0.01;

/// A control law on the testbed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TestedLaw {
    /// Mode of the controller.
    pub mode: &'static str,
    /// Whether the controller is told the load's force beforehand, as the decomposition of the
    /// whole machine would tell it.
    pub previewed: bool,
}

impl TestedLaw {
    const fn new(mode: &'static str, previewed: bool) -> Self {
        Self { mode, previewed }
    }
}

/// The law with preview. It must meet the targets; if it does not, the code is wrong.
pub const CHECK: TestedLaw = TestedLaw::new("adaptive", true);

/// The laws without preview.
pub(crate) const UNKNOWN_LOAD: [TestedLaw; 5] = [
    TestedLaw::new("adaptive", false),
    TestedLaw::new("modular", false),
    TestedLaw::new("pd", false),
    TestedLaw::new("modular_integral", false),
    TestedLaw::new("pd_integral", false),
];

/// What loads an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Load {
    /// A load emulator: a force with a first-order lag.
    Emulator,
    /// A second rig under force control.
    Rig,
}

/// An axis and what loaded it.
#[derive(Clone, Debug, Serialize)]
pub struct LoadedAxis {
    /// The load.
    pub load: Load,
    /// The axis.
    #[serde(flatten)]
    pub axis: Axis,
}

/// Root mean square and maximum of an error, and the peak of the reference.
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
    /// The control law.
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
    /// Whether the position error meets [`POSITION_TARGET`].
    pub(crate) fn meets_position_target(&self) -> bool {
        self.position.rmse <= POSITION_TARGET
    }

    /// Whether the force error meets [`FORCE_TARGET`].
    pub(crate) fn meets_force_target(&self) -> bool {
        self.force.rmse <= FORCE_TARGET * self.force.peak
    }
}

impl AxisError {
    /// The error from sample `first` on.
    pub(super) fn new([desired, actual]: &[Vec<f64>; 2], first: usize) -> Self {
        let (mut error, mut peak) = (Distance::default(), 0.0_f64);
        for (d, a) in desired.iter().zip(actual).skip(first) {
            error.add((d - a).abs());
            peak = peak.max(d.abs());
        }
        Self {
            rmse: error.rms(),
            max: error.max,
            peak,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_count_from_the_first_sample_of_the_motion() {
        let courses = [vec![9.0, 1.0, -2.0], vec![0.0, 4.0, 2.0]];
        let t = AxisError::new(&courses, 1);
        assert_eq!((t.rmse, t.max, t.peak), (12.5f64.sqrt(), 4.0, 2.0));
    }
}
