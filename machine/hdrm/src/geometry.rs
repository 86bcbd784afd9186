//! Kinematics for plant, controller and studies: bodies, closed loops, tree of joints, tip.

pub(crate) mod body;
pub(crate) mod lift;
pub(crate) mod planar;
pub(crate) mod planar_body;
pub(crate) mod tilt;
pub(crate) mod tip;
pub(crate) mod tree;
