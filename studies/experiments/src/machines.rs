//! Computes from a machine file without a run, for `machine`, `path`, `setup` and the report:
//! machines of other sizes, torques that motors can give continuously, margins along a path.

pub mod continuous_torque;
pub mod path_margins;
pub mod scaling;
