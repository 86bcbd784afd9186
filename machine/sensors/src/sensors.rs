//! The sensors of one machine: their configuration, and the errors that each of them keeps.

use crate::params::{DELAY_MAX, Params};
use crate::random::FixedErrors;
use serde::{Deserialize, Serialize};

/// The sensors: parameters, and the errors drawn from the seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensors {
    pub(crate) p: Params,
    pub(crate) drawn: FixedErrors,
}

impl Sensors {
    /// Sensors with these parameters; `delay` beyond [`DELAY_MAX`] counts as that.
    pub fn new(p: Params) -> Self {
        Self {
            drawn: FixedErrors::from_seed(p.seed),
            p: Params {
                delay: p.delay.min(DELAY_MAX),
                ..p
            },
        }
    }
}
