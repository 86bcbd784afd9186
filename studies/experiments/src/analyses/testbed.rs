//! The one-axis experiment (the paper's "Experimental Results"), for the subcommand `testbed` and
//! the report: single actuators replay what the rods did in a run of the whole machine.

mod axis;
mod load_rig;
mod profile;
mod replay;
mod study;

pub use axis::{Axis, CHECK};
pub(crate) use axis::{AxisError, FORCE_TARGET, Load, LoadedAxis, POSITION_TARGET, UNKNOWN_LOAD};
pub(crate) use profile::record;
pub use profile::{MachineRun, ports};
pub use study::Replay;
pub(crate) use study::{RIG_SYSTEM, SYSTEM, judge};
