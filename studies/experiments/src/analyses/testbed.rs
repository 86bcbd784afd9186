//! The one-axis experiment.

mod axis;
mod load_rig;
mod profile;
mod replay;
mod study;

pub use axis::{
    Axis, AxisError, CHECK, Course, FORCE_TARGET, Load, LoadedAxis, POSITION_TARGET, TestedLaw,
    UNKNOWN_LOAD,
};
pub use profile::{MachineRun, ports, record};
pub use study::{RIG_SYSTEM, Replay, SYSTEM, judge};
