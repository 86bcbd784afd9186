//! The whole machine file as one struct, from which models and FMUs are built, and its check.

use crate::actuator::{Emla, Ratings};
use crate::bodies::{Bodies, Limits, Start};
use crate::check::{Findings, MachineError};
use crate::controller::{Controller, Trajectories};
use crate::geometry::Geometry;
use crate::per_axis::PerAxis;
use serde::{Deserialize, Serialize};

/// Part of a stroke by which the joint's range may exceed it.
const STROKE_SPARE: f64 = 0.1;

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
        self.examine_slew(found);
        self.emla.examine(Emla::examine, found);
        self.ratings.examine(Ratings::examine, found);
        self.start.examine(&self.limits, found);
        self.trajectories.examine(found);
        self.controller.examine(found);
    }

    /// The slew actuator moves a rack, `x_1 = x1_mid + r_B·zeta_1`: its stroke bounds the joint.
    fn examine_slew(&self, found: &mut Findings) {
        let (middle, radius, stroke) = (
            self.geometry.x1_mid,
            self.geometry.r_B,
            self.limits.stroke_1,
        );
        if !(stroke[0]..=stroke[1]).contains(&middle) {
            let rule =
                format!("within the stroke of the slew actuator, `limits.stroke_1` = {stroke:?}");
            return found.refuse("geometry.x1_mid", middle, rule);
        }
        // Dimensions that are drawn at random may miss the stroke's ends by a little.
        let spare = STROKE_SPARE * (stroke[1] - stroke[0]);
        let [min, max] = [self.limits.zeta_min_deg[0], self.limits.zeta_max_deg[0]];
        for (name, most, angle, end, side) in [
            ("zeta_min_deg", "least", min, stroke[0], -1.0),
            ("zeta_max_deg", "most", max, stroke[1], 1.0),
        ] {
            if side * (middle + radius * angle.to_radians() - end) > spare {
                let bound = ((end - middle) / radius).to_degrees();
                let rule = format!(
                    "at {most} {bound:.1}: the slew actuator's stroke, `limits.stroke_1` = {stroke:?}, turns no further"
                );
                found.refuse(format_args!("limits.{name}[1]"), angle, rule);
            }
        }
    }
}
