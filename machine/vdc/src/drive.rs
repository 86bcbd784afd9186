//! The low level: from the required force and motion of a rod to the voltages of its drive.

mod reading;
mod voltage_law;

pub(crate) use reading::Reading;
pub(crate) use voltage_law::{Command, DriveState, RodDemand, VoltageLaw, residual_forces};
