//! Whether motors and actuators are large enough for what they do, for the subcommand `sizing` and
//! the report (page and figures).

mod axis;
mod motor;
mod payload;
mod recorded;
mod study;

pub use axis::{Axis, WINDING_LIMIT};
pub use recorded::ports;
pub use study::{Sizing, cases, evaluate, run};
