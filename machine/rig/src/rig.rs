//! An actuator as built, as the FMU `Rig` or a study makes it: parameters, effects, drive mode.

use crate::current_loop::CurrentLoop;
use crate::extras::Extras;
use machine_file::{ActuatorInput, Drive, MachineError};
use model_rules::ParamError;
use serde::{Deserialize, Serialize};

/// One actuator as built.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rig {
    pub(crate) p: machine_file::Emla,
    pub(crate) extra: Extras,
    pub(crate) drive: Drive,
    /// Longest substep for these parameters, s.
    pub(crate) dt_max: f64,
    /// Number of communication steps after which the force acts.
    pub(crate) delay: u32,
    /// Voltage of the DC link below which an enabled drive trips, V; 0: never.
    pub(crate) undervoltage: f64,
    /// The drive's own current loop; None: the inputs are voltages.
    pub(crate) current_loop: Option<CurrentLoop>,
}

impl Rig {
    /// An actuator with these parameters, or the first value out of its range.
    pub fn new(p: machine_file::Emla, extra: Extras, drive: Drive) -> Result<Self, RigError> {
        p.check()?;
        extra.check(&p)?;
        let mut rig = Self {
            p,
            extra,
            drive,
            dt_max: 0.0,
            delay: 0,
            undervoltage: 0.0,
            current_loop: None,
        };
        rig.dt_max = rig.longest_substep();
        Ok(rig)
    }

    /// Sets the number of communication steps after which the force acts, and over which it is
    /// therefore predicted.
    #[must_use]
    pub fn with_delay(self, delay: u32) -> Self {
        Self { delay, ..self }
    }

    /// Sets the DC-link voltage, V, below which an enabled drive trips: gates off, brake applied.
    #[must_use]
    pub fn with_undervoltage(self, undervoltage: f64) -> Self {
        Self {
            undervoltage,
            ..self
        }
    }

    /// Sets the drive's own current loop, which follows the input `i_q_required` instead of the
    /// voltages. It needs a sampling inverter ([`Extras::switching`](crate::Extras::switching)).
    #[must_use]
    pub fn with_current_loop(self, current_loop: Option<CurrentLoop>) -> Self {
        Self {
            current_loop,
            ..self
        }
    }

    /// Voltage of the DC link below which the drive trips, V; 0: never.
    pub fn undervoltage(&self) -> f64 {
        self.undervoltage
    }

    /// Voltage of the DC link, V: the input's, or the machine's.
    pub fn link_voltage(&self, u: &ActuatorInput) -> f64 {
        u.v_dc.unwrap_or_else(|| self.p.link_voltage())
    }

    /// Drive mode.
    pub fn drive(&self) -> Drive {
        self.drive
    }

    /// Parameters that it shares with the idealised model.
    pub fn params(&self) -> &machine_file::Emla {
        &self.p
    }

    /// The effects beyond the idealised model.
    pub fn extras(&self) -> &Extras {
        &self.extra
    }
}

/// Why a configuration was refused.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// A parameter shared with the idealised actuator.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// One of the extras, by group and field.
    #[error(transparent)]
    Extra(#[from] ParamError),
}

#[cfg(test)]
impl Rig {
    /// The reference machine's actuator with every extra, moved by a mechanism.
    pub(crate) fn as_built() -> Self {
        let p = machine_file::Machine::reference().emla.lift;
        Self::new(p, Extras::AS_BUILT, Drive::Motion).expect("valid")
    }
}
