//! Whether motors and actuators fit what they do.

mod axis;
mod motor;
mod payload;
mod recorded;
mod study;

pub use axis::{Axis, HOUR, WINDING_LIMIT};
pub use motor::Motor;
pub use payload::{Metrics, Sensitivity};
pub use recorded::{Size, ports};
pub use study::{Sizing, evaluate, run};
