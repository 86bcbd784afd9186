//! Inputs of an actuator as the importer sees them, and where its rod is between two sets of the
//! input `x`.
//!
//! The rod moves on with its velocity, in a step and from one step to the next, until `x` is set
//! again: holding it while x_dot ≠ 0 would cost K_b·x_dot·h of force, some 20 kN at 1 ms. So after
//! a step the outputs belong to the new time, before the importer has set anything. What remembers
//! it is a [`Carried`], part of the FMU's state.

use crate::info::{ROOM_TEMPERATURE, X_LARGEST, X_START};
use fmu_export::{Carried, Counted, ModelError};
use machine_file::{ActuatorInput, EmlaFields};
use serde::{Deserialize, Serialize};

/// Inputs as the importer sees them.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    /// The model's; position of the rod and voltage of the DC link follow from the other fields.
    pub u: ActuatorInput,
    /// Voltage of the DC link, V; until it is set, that of the machine counts.
    pub v_dc: Counted<f64>,
    /// Rod position, m.
    pub x: Counted<f64>,
}

impl Input {
    /// Inputs that nobody has set.
    pub fn unset(of_machine: &EmlaFields) -> Self {
        Self {
            u: ActuatorInput {
                T_ambient: ROOM_TEMPERATURE,
                ..ActuatorInput::default()
            },
            v_dc: Counted::unset(of_machine.inverter.v_dc),
            x: Counted::unset(X_START),
        }
    }

    /// The model's inputs with the rod where it is now; a voltage of the DC link that nobody has
    /// set is the machine's.
    pub fn now(&self, rod: &Carried<f64>) -> ActuatorInput {
        ActuatorInput {
            x: rod.now(&self.x),
            v_dc: self.v_dc.told(),
            ..self.u
        }
    }

    /// The direction of a derivative, or a derivative by time: in them nothing is set, and every
    /// number counts.
    pub fn direction(&self) -> ActuatorInput {
        ActuatorInput {
            x: self.x.value,
            v_dc: Some(self.v_dc.value),
            ..self.u
        }
    }
}

/// The rod at the end of a step that takes it to `x`, m, and no farther from 0 than `farthest`, m.
pub fn rod_end(input: &Counted<f64>, x: f64, farthest: f64) -> Result<Carried<f64>, ModelError> {
    if farthest > X_LARGEST {
        return Err(ModelError::new(format!(
            "`x_dot` moves the rod to |x| = {farthest} m within the step; it must stay within {X_LARGEST} m"
        )));
    }
    Ok(Carried::moved(input, x))
}
