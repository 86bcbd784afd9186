//! Why the controller refuses.

use hdrm::{Body, GeometryError};
use machine_file::MachineError;
use thiserror::Error;

/// Longest step, s: measurements held for longer than that mean nothing, and filters with large
/// gains would overflow.
pub(crate) const STEP_MAX: f64 = 100.0;

/// Why no controller could be made, or a step was refused.
#[derive(Debug, Error)]
pub enum ControllerError {
    /// A parameter outside its range.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// Geometry that is not a working machine.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The adaptation needs positive definite pseudo-inertias.
    #[error(
        "`bodies.{body:?}`: mass, com and inertia_com are no physical body, so it cannot be adapted"
    )]
    NotPhysical {
        /// The body.
        body: Body,
    },
    /// A reference orientation without direction.
    #[error("`reference.orientation` has length {norm}: it must be a quaternion of length 1")]
    Orientation {
        /// Its length.
        norm: f64,
    },
    /// A limit of commanded rates.
    #[error("`{name}` = {value} must be finite and > 0")]
    RateLimit {
        /// Parameter.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A path that cannot be made.
    #[error(transparent)]
    Path(#[from] tip_path::PathError),
    /// The plant that a path is checked with.
    #[error(transparent)]
    Plant(#[from] hdrm::HdrmError),
    /// A path that the nominal machine cannot do.
    #[error("{0}")]
    Refused(String),
    /// The nominal actuator cannot be computed over the delay.
    #[error("prediction over the delay: {0}")]
    Prediction(#[from] emla::StepError),
    /// Unusable step size.
    #[error("t = {t} s: step h = {h} s must be > 0 and at most {STEP_MAX} s")]
    BadStep {
        /// Start of the step, s.
        t: f64,
        /// Step, s.
        h: f64,
    },
    /// A command, or another output, became infinite or NaN.
    #[error("t = {t} s: `{signal}` became {value}; it must be finite")]
    NotFinite {
        /// Time, s.
        t: f64,
        /// Its name.
        signal: &'static str,
        /// Its value.
        value: f64,
    },
}
