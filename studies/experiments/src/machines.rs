//! Computes from a machine file without a run, for `machine`, `path`, `setup` and the report:
//! machines of other sizes, torques that motors can give continuously, margins along a path,
//! gains as a parameter set, files for tools of robotics.

pub mod continuous_torque;
mod element;
pub mod gains;
pub mod path_margins;
pub mod robot;
pub mod scaling;
pub mod strokes;
