//! Why a plant could not be built or loaded, for the FMU, the path check and the controller.

use crate::geometry::tree::GeometryError;
use model_rules::ParamError;
use thiserror::Error;

/// Why a plant could not be built.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum HdrmError {
    /// The mechanism does not work.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A number is out of its range.
    #[error(transparent)]
    Value(#[from] ParamError),
}
