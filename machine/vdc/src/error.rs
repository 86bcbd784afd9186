//! Errors of the controller, for the FMU: invalid parameters or paths, bad steps, infinite results.

use hdrm::{Body, GeometryError};
use machine_file::MachineError;
use machine_file::Seconds;
use thiserror::Error;

/// Longest step, s; beyond it held measurements are meaningless and filters may overflow.
pub(crate) const STEP_MAX: f64 = 100.0;

/// Why a controller could not be built, or a step failed.
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
    /// A reference orientation of length zero.
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
    /// A path that cannot be planned.
    #[error(transparent)]
    Path(#[from] tip_path::PathError),
    /// An error of the machine model that checks a path.
    #[error(transparent)]
    Plant(#[from] hdrm::HdrmError),
    /// A path that the nominal machine cannot follow.
    #[error("{0}")]
    Refused(String),
    /// An error of the prediction over the delay.
    #[error("prediction over the delay: {0}")]
    Prediction(#[from] emla::StepError),
    /// Unusable step size.
    #[error("t = {} s: step h = {} s must be > 0 and at most {STEP_MAX} s", Seconds(*t), Seconds(*h))]
    BadStep {
        /// Start of the step, s.
        t: f64,
        /// Step, s.
        h: f64,
    },
    /// `learning` without laps to learn from.
    #[error(
        "`learning` = {0} needs a path of equal laps, of more than 1.1 s each: `trajectory` = path with a file that has `laps`"
    )]
    NoLaps(f64),
    /// A command, or another output, became infinite or NaN.
    #[error("t = {} s: `{signal}` became {value}; it must be finite", Seconds(*t))]
    NotFinite {
        /// Time, s.
        t: f64,
        /// Its name.
        signal: &'static str,
        /// Its value.
        value: f64,
    },
}
