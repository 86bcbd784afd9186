//! What is told of machine files without a run: other sizes, torques that motors may give for ever,
//! margins along a path.

pub mod continuous_torque;
pub mod path_margins;
pub mod scaling;
