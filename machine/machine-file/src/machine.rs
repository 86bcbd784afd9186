//! The whole machine file as one struct, from which models and FMUs are built, and its check.

use crate::actuator::{Emla, Ratings};
use crate::bodies::{Bodies, Limits, Start};
use crate::check::{Findings, MachineError};
use crate::controller::{Controller, Trajectories};
use crate::geometry::Geometry;
use crate::per_axis::PerAxis;
use serde::{Deserialize, Serialize};

/// Everything that describes one machine: mechanism, actuators, references and controller gains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
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
    #[cfg_attr(test, schemars(with = "Emla"))]
    pub emla: PerAxis<Emla>,
    /// What the actuators are rated for: one section for all, or one for each.
    #[cfg_attr(test, schemars(with = "Ratings"))]
    pub ratings: PerAxis<Ratings>,
    /// Pose in which a run starts.
    pub start: Start,
    /// The paper's two tip trajectories.
    pub trajectories: Trajectories,
    /// Controller gains.
    pub controller: Controller,
}

impl Machine {
    /// Checks every value; to be called after values of a machine were changed.
    pub fn check(&self) -> Result<(), MachineError> {
        Findings::collect(|found| self.examine(found))
    }

    pub(crate) fn examine(&self, found: &mut Findings) {
        found.not_negative("gravity", self.gravity);
        self.geometry.examine(found);
        self.bodies.examine(found);
        for (i, &d) in self.joint_viscous.iter().enumerate() {
            found.not_negative(format_args!("joint_viscous[{}]", i + 1), d);
        }
        self.limits.examine(found);
        self.emla.examine(Emla::examine, found);
        self.ratings.examine(Ratings::examine, found);
        self.start.examine(&self.limits, found);
        self.trajectories.examine(found);
        self.controller.examine(found);
    }
}
