//! The network of `Surrogate::reference`; `build.rs` writes it from `parameters/surrogate.json`.

use super::file::{EfficiencyBound, MinMax, Ranges, Split, TrainingRecord};
use super::network::{Layer, Network};

include!(concat!(env!("OUT_DIR"), "/shipped.rs"));
