//! Range checks and the error they give.

use std::fmt::Display;
use thiserror::Error;

/// Why a machine was refused.
#[derive(Debug, Error)]
pub enum MachineError {
    /// Not JSON, or not of the machine's shape.
    #[error("machine JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A value outside its range.
    #[error("`{name}` = {value} must be {rule}")]
    Value {
        /// Path of the field, with dots.
        name: String,
        /// The refused value.
        value: String,
        /// What must hold.
        rule: String,
    },
}

/// Builds the error for `name`.
pub(crate) fn refuse(name: impl Display, value: impl Display, rule: impl Display) -> MachineError {
    MachineError::Value {
        name: name.to_string(),
        value: value.to_string(),
        rule: rule.to_string(),
    }
}

pub(crate) fn positive(name: impl Display, value: f64) -> Result<(), MachineError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(refuse(name, value, "finite and > 0"))
}

pub(crate) fn not_negative(name: impl Display, value: f64) -> Result<(), MachineError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(refuse(name, value, "finite and ≥ 0"))
}

pub(crate) fn finite(name: impl Display, values: &[f64]) -> Result<(), MachineError> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(value) => Err(refuse(name, value, "finite")),
    }
}

/// A closed interval, `[min, max]` with min < max.
pub(crate) fn interval(name: impl Display, [min, max]: [f64; 2]) -> Result<(), MachineError> {
    if min.is_finite() && max.is_finite() && min < max {
        return Ok(());
    }
    Err(refuse(
        name,
        format_args!("[{min}, {max}]"),
        "finite with minimum < maximum",
    ))
}
