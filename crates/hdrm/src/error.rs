//! Why a plant is refused.

use crate::tree::GeometryError;
use thiserror::Error;

/// Why a plant could not be built.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum HdrmError {
    /// The mechanism does not work.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A number is out of its range.
    #[error("`{name}` is {value}: it must be {rule}")]
    Value {
        /// Parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        rule: &'static str,
    },
}
