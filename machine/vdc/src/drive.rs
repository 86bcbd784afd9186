//! The low level of `controller`: a rod's required force and motion to the voltages of its drive.

mod reading;
mod voltage_law;

pub(crate) use reading::Reading;
pub(crate) use voltage_law::{Command, DriveState, RodDemand, VoltageLaw, residual_forces};
