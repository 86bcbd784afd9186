//! Inputs of an actuator as the importer sees them, and where its rod is between two sets of the
//! input `x`.
//!
//! The rod moves on with its velocity, in a step and from one step to the next, until `x` is set
//! again: holding it while x_dot ≠ 0 would cost K_b·x_dot·h of force, some 20 kN at 1 ms. So after
//! a step the outputs belong to the new time, before the importer has set anything. What remembers
//! it is an [`ExtrapolatedInput`], part of the FMU's state.

use crate::info::{ROOM, X_LARGEST, X_START};
use fmu_export::{CountedInput, ExtrapolatedInput, ModelError};
use machine_file::{ActuatorInput, EmlaFields};
use serde::{Deserialize, Serialize};

/// Inputs as the importer sees them.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    /// The model's; position of the rod and voltage of the DC link follow from the other fields.
    pub u: ActuatorInput,
    /// Voltage of the DC link, V; until it is set, that of the machine counts.
    pub v_dc: CountedInput<f64>,
    /// Rod position, m.
    pub x: CountedInput<f64>,
}

impl Input {
    /// Inputs that nobody has set.
    pub fn unset(of_machine: &EmlaFields) -> Self {
        Self {
            u: ActuatorInput {
                T_ambient: ROOM,
                ..ActuatorInput::default()
            },
            v_dc: CountedInput::new(of_machine.inverter.v_dc),
            x: CountedInput::new(X_START),
        }
    }

    /// The model's inputs with the rod where it is now; a voltage of the DC link that nobody has
    /// set is the machine's.
    pub fn now(&self, rod: &ExtrapolatedInput<f64>) -> ActuatorInput {
        ActuatorInput {
            x: rod.now(&self.x),
            v_dc: self.v_dc.if_set(),
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
///
/// # Errors
/// The rod leaves the bounds of the input `x` within the step.
pub fn rod_end(
    input: &CountedInput<f64>,
    x: f64,
    farthest: f64,
) -> Result<ExtrapolatedInput<f64>, ModelError> {
    if farthest > X_LARGEST {
        return Err(ModelError::new(format!(
            "`x_dot` moves the rod to |x| = {farthest} m within the step; it must stay within {X_LARGEST} m"
        )));
    }
    Ok(ExtrapolatedInput::with_value(input, x))
}
