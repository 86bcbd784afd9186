//! Options: in what a plant may differ from its machine file.

use crate::DOF;
use crate::contact::Contact;
use crate::dry_friction::DryFriction;
use crate::error::HdrmError;
use crate::load::Load;
use crate::wrist_drive::WristDrive;
use machine::Machine;
use serde::{Deserialize, Serialize};

/// What may differ from the machine file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Factor s on mass, first moment and inertia of every body, payload included.
    pub inertia_scale: f64,
    /// What the end-effector carries at first.
    pub load: Load,
    /// Viscous joint friction on `zeta_dot`, N·m·s/rad.
    pub joint_viscous: [f64; DOF],
    /// Acceleration of gravity in world axes, m/s²: not along −y where the machine does not stand
    /// plumb.
    pub gravity: [f64; 3],
    /// A plane that the tip may touch.
    pub contact: Contact,
    /// Dry friction of slew, lift and tilt joint.
    pub joint_dry: DryFriction,
    /// The wrist's drives.
    pub wrist: WristDrive,
}

impl Options {
    /// The machine as its file has it.
    #[must_use]
    pub fn of(machine: &Machine) -> Self {
        Self {
            inertia_scale: 1.0,
            load: Load::of(machine),
            joint_viscous: machine.joint_viscous,
            gravity: [0.0, -machine.gravity, 0.0],
            contact: Contact::default(),
            joint_dry: DryFriction::default(),
            wrist: WristDrive::IDEAL,
        }
    }

    /// Checks every value but those of the contact, whose plane is made of them.
    pub(crate) fn check(&self) -> Result<(), HdrmError> {
        let refuse = |name, value, rule| Err(HdrmError::Value { name, value, rule });
        let not_negative = |value: f64| value.is_finite() && value >= 0.0;
        let &Options {
            inertia_scale,
            load,
            joint_viscous,
            gravity,
            ..
        } = self;
        if !(inertia_scale.is_finite() && inertia_scale > 0.0) {
            return refuse("inertia_scale", inertia_scale, "finite and > 0");
        }
        load.check()?;
        self.joint_dry.check()?;
        self.wrist.check()?;
        if let Some(&value) = gravity.iter().find(|g| !g.is_finite()) {
            return refuse("gravity", value, "finite");
        }
        match joint_viscous.into_iter().find(|&d| !not_negative(d)) {
            Some(d) => refuse("joint_viscous", d, "finite and ≥ 0"),
            None => Ok(()),
        }
    }
}
