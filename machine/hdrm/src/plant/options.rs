//! Options with which the FMU or `motion-check` adds to the machine file or replaces values of it.

use crate::DOF;
use crate::forces::contact::Contact;
use crate::forces::dry_friction::DryFriction;
use crate::forces::wrist_brake::WristBrake;
use crate::forces::wrist_drive::WristDrive;
use crate::load::Load;
use machine_file::Machine;
use model_rules::{ParamError, Range, check, check_each};
use serde::{Deserialize, Serialize};

/// Options of the plant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Factor s on mass, first moment and inertia of every body, payload included.
    pub inertia_scale: f64,
    /// What the end-effector carries at the start.
    pub load: Load,
    /// Viscous joint friction on `zeta_dot`, N·m·s/rad.
    pub joint_viscous: [f64; DOF],
    /// Acceleration of gravity in world axes, m/s²; not along −y if the machine is not level.
    pub gravity: [f64; 3],
    /// A plane that the tip may touch.
    pub contact: Contact,
    /// Dry friction of slew, lift and tilt joint.
    pub joint_dry: DryFriction,
    /// The wrist's drives.
    pub wrist: WristDrive,
    /// The wrist's brakes.
    pub brake: WristBrake,
}

impl Options {
    /// The machine as in its file, without contact, dry friction and wrist drives as built.
    pub fn from_machine(machine: &Machine) -> Self {
        Self {
            inertia_scale: 1.0,
            load: Load::from_machine(machine),
            joint_viscous: machine.joint_viscous,
            gravity: [0.0, -machine.gravity, 0.0],
            contact: Contact::default(),
            joint_dry: DryFriction::default(),
            wrist: WristDrive::IDEAL,
            brake: WristBrake::for_drives(machine.limits.tau_wrist_max),
        }
    }

    /// Checks every value except those of the contact, which [`Contact::plane`] checks.
    pub(crate) fn check(&self) -> Result<(), ParamError> {
        check(Range::Positive, [("inertia_scale", self.inertia_scale)])?;
        self.load.check()?;
        self.joint_dry.check()?;
        self.wrist.check()?;
        self.brake.check()?;
        check_each(Range::Finite, "gravity", &self.gravity)?;
        check_each(Range::NotNegative, "joint_viscous", &self.joint_viscous)
    }
}
