//! What is made of machine files: other sizes, torques that motors may give for ever.

pub mod continuous_torque;
pub mod scaling;
