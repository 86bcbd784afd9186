//! The low level of `controller`: from a rod's required force and motion to its drive's voltages.

mod reading;
mod voltage_law;

pub(crate) use reading::Reading;
pub(crate) use voltage_law::{Command, DriveState, RodDemand, VoltageLaw, residual_forces};
