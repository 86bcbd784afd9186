//! Configuration for `sample`: parameters, and the constant errors drawn from the seed.

use crate::params::{DELAY_MAX, Params};
use crate::random::FixedErrors;
use serde::{Deserialize, Serialize};

/// The sensors of one machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensors {
    pub(crate) p: Params,
    pub(crate) drawn: FixedErrors,
}

impl Sensors {
    /// Sensors with these parameters; `delay` is limited to [`DELAY_MAX`].
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
