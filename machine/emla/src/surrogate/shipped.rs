//! The shipped network as constants; `build.rs` writes them from `parameters/surrogate.json`.

use super::file::{EfficiencyBound, MinMax, Ranges, Split, TrainingRecord};
use super::network::{Layer, Network};

include!(concat!(env!("OUT_DIR"), "/shipped.rs"));
