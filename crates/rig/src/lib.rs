//! The actuator as built: motor, drive, gear, screw and rod with what a controller's model of them leaves out.
//!
//! It stands in the place of the idealised actuator with the same inputs and outputs, and shares with it what trips and holds the drive
//! ([`machine::Holding`]); its equations are its own, written from the books named at the functions. [`Extras`] says what it knows beyond [`machine::Emla`]: saturation, temperature, ripple
//! and cogging, an inverter that holds its voltages in stator coordinates and comes late, stiction with presliding, backlash, compliance of
//! the mounting and torsion, larger losses, and heat. Each has a switch; with all of them off the equations are those of the idealised
//! actuator.
//!
//! The rod's position `x` and the force `F` are positive when the actuator extends. dq quantities are peak-valued and oriented to the rotor
//! flux. SI units throughout. [`Rig`] is the configuration; [`State`] is passed by value, so a step that fails changes nothing.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // symbols of the books

mod dynamics;
mod extras;
mod friction;
mod heat;
mod held;
mod inverter;
mod link;
mod motor;
mod output;
mod start;
mod state;
mod step;

pub use extras::{
    Backlash, Cogging, Compliance, Extras, Friction, Heat, Losses, Ripple, Saturation, Switching,
    Temperature,
};
pub use output::Output;
pub use state::{Energy, Hold, Powers, State};
pub use step::StepError;

use serde::{Deserialize, Serialize};

/// Who moves the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Drive {
    /// The rod follows the inputs `x` and `x_dot`; the force on it is the answer.
    Motion,
    /// The rod is a mass of its own against the input `F_ext`.
    Force,
}

/// What acts on the actuator at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Commanded direct-axis voltage, V.
    pub v_d: f64,
    /// Commanded quadrature-axis voltage, V.
    pub v_q: f64,
    /// Voltage of the DC link, V.
    pub v_dc: f64,
    /// Whether the inverter's gates are on, as they are by default. Read at the start of a step.
    pub enable: bool,
    /// Whether the holding brake is applied; a drive that has tripped applies it too. Read at the start of a step.
    pub brake: bool,
    /// Temperature around the actuator, K.
    pub T_ambient: f64,
    /// Rod position, m. In [`Drive::Force`] read at the start only.
    pub x: f64,
    /// Rod velocity, m/s. In [`Drive::Force`] read at the start only.
    pub x_dot: f64,
    /// External force on the rod against extension, N. [`Drive::Force`] only.
    pub F_ext: f64,
    /// Force that the actuator delivers at the start, N. Read at the start only.
    pub F_hold: f64,
}

impl Default for Input {
    /// All zero; gates on, brake released.
    fn default() -> Self {
        Self {
            v_d: 0.0,
            v_q: 0.0,
            v_dc: 0.0,
            enable: true,
            brake: false,
            T_ambient: 0.0,
            x: 0.0,
            x_dot: 0.0,
            F_ext: 0.0,
            F_hold: 0.0,
        }
    }
}

/// One actuator as built.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rig {
    pub(crate) p: machine::Emla,
    pub(crate) extra: Extras,
    pub(crate) drive: Drive,
    /// Longest substep for these parameters, s.
    pub(crate) dt_max: f64,
    /// Communication steps by which the force acts late.
    pub(crate) delay: u32,
    /// Voltage of the DC link below which an enabled drive trips, V; 0: never.
    pub(crate) undervoltage: f64,
}

impl Rig {
    /// An actuator with these parameters.
    ///
    /// # Errors
    /// A parameter outside its physical range, by name, value and rule.
    pub fn new(p: machine::Emla, extra: Extras, drive: Drive) -> Result<Self, RigError> {
        p.check()?;
        extra.check(&p)?;
        let mut rig = Self {
            p,
            extra,
            drive,
            dt_max: 0.0,
            delay: 0,
            undervoltage: 0.0,
        };
        rig.dt_max = rig.longest_substep();
        Ok(rig)
    }

    /// The same actuator, whose force is given `delay` communication steps ahead, because it acts so late.
    #[must_use]
    pub fn with_delay(self, delay: u32) -> Self {
        Self { delay, ..self }
    }

    /// The same actuator, whose drive trips when it is enabled and its DC link is below `undervoltage`, V: gates off, brake applied.
    #[must_use]
    pub fn with_undervoltage(self, undervoltage: f64) -> Self {
        Self {
            undervoltage,
            ..self
        }
    }

    /// Voltage of the DC link below which the drive trips, V; 0: never.
    #[must_use]
    pub fn undervoltage(&self) -> f64 {
        self.undervoltage
    }

    /// Drive mode.
    #[must_use]
    pub fn drive(&self) -> Drive {
        self.drive
    }

    /// Parameters that it shares with its idealised model.
    #[must_use]
    pub fn params(&self) -> &machine::Emla {
        &self.p
    }

    /// What it knows beyond them.
    #[must_use]
    pub fn extras(&self) -> &Extras {
        &self.extra
    }
}

/// Why a rig was refused.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// A parameter shared with the idealised actuator.
    #[error(transparent)]
    Machine(#[from] machine::MachineError),
    /// One of the extras.
    #[error("`{name}` = {value} must be {rule}")]
    Extra {
        /// Group and field.
        name: &'static str,
        /// The refused value.
        value: f64,
        /// What must hold.
        rule: &'static str,
    },
}

#[cfg(test)]
impl Rig {
    /// The reference machine's actuator with every extra, moved by a mechanism.
    fn as_built() -> Self {
        let p = machine::Machine::reference().emla.lift;
        Self::new(p, Extras::AS_BUILT, Drive::Motion).expect("valid")
    }
}
