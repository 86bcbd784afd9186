//! The error of a machine without gains.

use super::feedback::{LEAST_FEEDBACK, SLOW_DAMPING};
use crate::drive_loop::Mode;
use hdrm::HdrmError;
use std::fmt;

/// Why a machine has no gains.
#[derive(Clone, Debug)]
pub enum GainError {
    /// There is no plant of it.
    Plant(HdrmError),
    /// This mode stays undamped however little the tip is fed back, with these gains of the user's.
    Undamped(Mode, Vec<&'static str>),
}

impl From<HdrmError> for GainError {
    fn from(error: HdrmError) -> Self {
        Self::Plant(error)
    }
}

impl std::error::Error for GainError {}

impl fmt::Display for GainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plant(error) => error.fmt(f),
            Self::Undamped(Mode { damping, hertz }, own) => {
                write!(
                    f,
                    "the rule has no `controller.Lambda_position` for this machine: with {LEAST_FEEDBACK} 1/s a mode at {hertz:.1} Hz has {:.1} % \
                     of damping, less than {:.0} %; ",
                    100.0 * damping,
                    100.0 * SLOW_DAMPING
                )?;
                let own = own.join("` and `");
                match &*own {
                    "" => f.write_str("other gears, motors or dimensions are needed, or gains of your own under `controller`"),
                    own => write!(f, "your own `{own}` may be why: leave it to the rule, or give a `Lambda_position` too"),
                }
            }
        }
    }
}
