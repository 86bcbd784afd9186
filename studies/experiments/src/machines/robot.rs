//! Writes a machine for the tools of robotics (`machine export`): MJCF for MuJoCo with both closed
//! loops, URDF as a tree.

mod links;
mod mjcf;
mod urdf;

pub use links::{Robot, equivalent_box};
pub use mjcf::mjcf;
pub use urdf::urdf;
