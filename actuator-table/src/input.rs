//! Inputs of the FMUs `Emla` and `Rig`, and the rod's position between two calls that set `x`.
//!
//! The rod keeps moving with its velocity, within a step and from one step to the next, until `x`
//! is set again: holding it while x_dot ≠ 0 would falsify the force by K_b·x_dot·h, some 20 kN at
//! 1 ms. So after a step the outputs belong to the new time, even before the importer sets an
//! input. The extrapolated position is a [`ExtrapolatedInput`], part of the FMU's state.

use crate::info::{ROOM_TEMPERATURE, X_LARGEST, X_START};
use fmu_export::{CountedInput, ExtrapolatedInput, ModelError};
use machine_file::{ActuatorInput, EmlaFields};
use serde::{Deserialize, Serialize};

/// Inputs as the importer sets them.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    /// Inputs of the model; its rod position and DC-link voltage come from the other two fields.
    pub u: ActuatorInput,
    /// Voltage of the DC link, V; until it is set, the machine file's is used.
    pub v_dc: CountedInput<f64>,
    /// Rod position, m.
    pub x: CountedInput<f64>,
}

impl Input {
    /// Start values of the inputs; none has been set.
    pub fn unset(of_machine: &EmlaFields) -> Self {
        Self {
            u: ActuatorInput {
                T_ambient: ROOM_TEMPERATURE,
                ..ActuatorInput::default()
            },
            v_dc: CountedInput::new(of_machine.inverter.v_dc),
            x: CountedInput::new(X_START),
        }
    }

    /// The model's inputs, with the rod where it is now.
    pub fn now(&self, rod: &ExtrapolatedInput<f64>) -> ActuatorInput {
        ActuatorInput {
            x: rod.now(&self.x),
            v_dc: self.v_dc.if_set(),
            ..self.u
        }
    }

    /// The model's inputs of a seed or of time derivatives, where every value counts as set.
    pub fn direction(&self) -> ActuatorInput {
        ActuatorInput {
            x: self.x.value,
            v_dc: Some(self.v_dc.value),
            ..self.u
        }
    }
}

/// The rod at the end of a step that takes it to `x`, m; `farthest` is the largest |x| within the
/// step, m. An error if that is beyond the bounds of the input `x`.
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
