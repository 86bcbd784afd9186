//! Spatial (6-D) vector algebra for rigid-body dynamics, used by `hdrm` (plant), `vdc` (controller)
//! and the identification study. The paper's convention: a twist is `[v; w]` (velocity of the
//! frame's origin, angular velocity), a wrench is `[f; m]` (force, moment about the frame's
//! origin), both expressed in and about the frame they belong to
//! (`[paper] Eq. (Eq:linear_angular)`, `(Eq:Force_Moment)`, `(Eq:Transformation)`).
//!
//! Twists and wrenches are dual and have different types, so that they cannot be mixed up.
//! All quantities are SI. Frames are named by suffixes: `V_A` is a twist in frame A, `X_AB` the
//! pose of frame B in frame A.
#![forbid(unsafe_code)]
#![allow(non_snake_case)]

mod inertia;
mod pair;
mod pose;
mod pseudo_inertia;
mod twist;
mod wrench;

pub use inertia::Inertia;
pub use pose::Pose;
pub use pseudo_inertia::PseudoInertia;
pub use twist::Twist;
pub use wrench::Wrench;
