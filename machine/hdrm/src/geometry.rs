//! Geometry and kinematics: bodies, the two closed loops, the tree of joints, the tip.

pub(crate) mod body;
pub(crate) mod lift;
pub(crate) mod planar;
pub(crate) mod planar_body;
pub(crate) mod tilt;
pub(crate) mod tip;
pub(crate) mod tree;
