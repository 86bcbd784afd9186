//! A whole machine.

use crate::actuator::{Emla, Ratings};
use crate::bodies::{Bodies, Limits, Start};
use crate::check::{MachineError, not_negative};
use crate::controller::{Controller, Trajectories};
use crate::geometry::Geometry;
use crate::per_axis::PerAxis;
use serde::{Deserialize, Serialize};

/// Everything that describes one machine: mechanism, actuators, references and controller gains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Gravitational acceleration along world −y, m/s².
    pub gravity: f64,
    /// Mechanism dimensions.
    pub geometry: Geometry,
    /// Inertial parameters of the 13 bodies.
    pub bodies: Bodies,
    /// Viscous joint friction acting on `zeta_dot`, N·m·s/rad.
    pub joint_viscous: [f64; 6],
    /// Strokes, joint ranges and wrist torque limits.
    pub limits: Limits,
    /// Electromechanical linear actuators: one section for all, or one for each.
    pub emla: PerAxis<Emla>,
    /// What the actuators are rated for: one section for all, or one for each.
    pub ratings: PerAxis<Ratings>,
    /// Pose in which a run starts.
    pub start: Start,
    /// The paper's two tip trajectories.
    pub trajectories: Trajectories,
    /// Controller gains.
    pub controller: Controller,
}

impl Machine {
    /// Reads and checks a machine.
    ///
    /// # Errors
    /// Malformed JSON, an unknown, missing or wrongly typed field (with line and column), or a
    /// value outside its physical range (with name, value and rule).
    pub fn from_json(json: &str) -> Result<Self, MachineError> {
        let machine: Self = serde_json::from_str(json)?;
        machine.check()?;
        Ok(machine)
    }

    /// Checks every value; called by [`Machine::from_json`] and wherever values were changed since.
    ///
    /// # Errors
    /// The first value outside its range.
    pub fn check(&self) -> Result<(), MachineError> {
        not_negative("gravity", self.gravity)?;
        self.geometry.check()?;
        self.bodies.check()?;
        for (i, &d) in self.joint_viscous.iter().enumerate() {
            not_negative(format_args!("joint_viscous[{}]", i + 1), d)?;
        }
        self.limits.check()?;
        self.emla.check(Emla::check)?;
        self.ratings.check(Ratings::check)?;
        self.start.check(&self.limits)?;
        self.trajectories.check()?;
        self.controller.check()
    }
}
