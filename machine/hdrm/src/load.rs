//! What the end-effector carries, as the FMU `Hdrm` and `motion-check` set it: the body `PL` is the
//! sum of the payload, whose mass and centre of mass may differ from the machine file's, and a
//! load, a point mass that is picked up and set down ([`crate::load::reload`]).

pub(crate) mod reload;

use machine_file::Machine;
use model_rules::{ParamError, Range, check, check_each};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use spatial::Inertia;

/// What the end-effector carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Mass of the payload, kg, before `inertia_scale`; its inertia is scaled with it. 0: none.
    pub payload_mass: f64,
    /// Centre of mass of the payload from D4's origin, in D4's axes, m.
    pub payload_com: [f64; 3],
    /// Mass of the load, kg, a point mass to which `inertia_scale` does not apply. 0: none.
    pub mass: f64,
    /// Position of the load from the tip T4, in T4's axes, m.
    pub com: [f64; 3],
}

impl Load {
    /// The payload of the machine file, and no load.
    pub fn from_machine(machine: &Machine) -> Self {
        Self {
            payload_mass: machine.bodies.PL.mass,
            payload_com: machine.bodies.PL.com,
            ..Self::default()
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParamError> {
        let masses = [
            ("payload.mass", self.payload_mass),
            ("load.mass", self.mass),
        ];
        check(Range::NotNegative, masses)?;
        check_each(Range::Finite, "payload.com", &self.payload_com)?;
        check_each(Range::Finite, "load.com", &self.com)
    }
}

/// The payload of the machine file, from which the body `PL` is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Payload {
    /// kg.
    mass: f64,
    /// About the centre of mass, kg·m².
    I_com: Matrix3<f64>,
    inertia_scale: f64,
    /// Position of the tip in D4, m.
    pub(crate) r_D4_T4: Vector3<f64>,
}

impl Payload {
    pub(crate) fn new(machine: &Machine, inertia_scale: f64) -> Self {
        let PL = &machine.bodies.PL;
        Self {
            mass: PL.mass,
            I_com: PL.inertia_com.rows().into(),
            inertia_scale,
            r_D4_T4: machine.geometry.r_D4_T4.into(),
        }
    }

    /// The body `PL` about D4's origin, in D4's axes.
    pub(crate) fn inertia(&self, load: &Load) -> Inertia {
        let share = load.payload_mass / self.mass;
        let payload = Inertia::from_com(self.mass, load.payload_com.into(), self.I_com)
            * (share * self.inertia_scale);
        if load.mass == 0.0 {
            return payload;
        }
        let r = self.r_D4_T4 + Vector3::from(load.com);
        payload + Inertia::from_com(load.mass, r, Matrix3::zeros())
    }
}
