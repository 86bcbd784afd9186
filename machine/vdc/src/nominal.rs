//! The controller's constant knowledge of the machine, for all its stages: mechanism, friction,
//! actuators, limits. The inertias, which loads and adaptation change, are in [`crate::bodies`].

mod singularities;
mod tip;

pub(crate) use singularities::{Inverse, Singularities};
pub(crate) use tip::orientation;
pub use tip::tip_pose;

use crate::error::ControllerError;
use emla::{Drive, Emla, Surrogate};
use hdrm::Tree;
use machine_file::Machine;
use motion_check::Reach;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Nominal {
    pub(crate) tree: Tree,
    pub(crate) joint_viscous: [f64; 6],
    pub(crate) tau_wrist_max: [f64; 3],
    /// Rated forces, N, and speeds, m/s, of the rods.
    pub(crate) ratings: [[f64; 2]; 3],
    pub(crate) gravity: f64,
    /// Slew, lift and tilt.
    pub(crate) actuators: [Emla; 3],
    /// The same without the network.
    pub(crate) physics: [Emla; 3],
    pub(crate) reach: Reach,
    pub(crate) singularities: Singularities,
}

impl Nominal {
    pub(crate) fn new(machine: &Machine, surrogate: &Surrogate) -> Result<Self, ControllerError> {
        let [slew, lift, tilt] = machine
            .emla
            .in_order()
            .map(|p| Emla::new(*p, Drive::Motion));
        let physics = [slew?, lift?, tilt?];
        let tree = Tree::new(machine)?;
        Ok(Self {
            singularities: Singularities::new(&tree),
            tree,
            joint_viscous: machine.joint_viscous,
            tau_wrist_max: machine.limits.tau_wrist_max,
            ratings: (machine.ratings.in_order()).map(|r| [r.force_max, r.rod_speed_max]),
            gravity: machine.gravity,
            actuators: physics
                .clone()
                .map(|physics| physics.with_surrogate(surrogate.clone(), 0.0)),
            physics,
            reach: Reach::new(&machine.geometry),
        })
    }

    pub(crate) fn parameters(&self) -> [&machine_file::Emla; 3] {
        self.actuators.each_ref().map(Emla::params)
    }

    /// Actuator `i` with the network's weight `alpha`.
    pub(crate) fn actuator(&self, i: usize, alpha: f64) -> Cow<'_, Emla> {
        if alpha == 0.0 {
            return Cow::Borrowed(&self.physics[i]);
        }
        let mut hybrid = self.actuators[i].clone();
        hybrid.set_alpha(alpha);
        Cow::Owned(hybrid)
    }
}
