//! Spatial (6-D) vector algebra of rigid bodies in the paper's convention: a twist is `[v; w]`
//! (velocity of the frame's origin, angular velocity), a wrench is `[f; m]` (force, moment about
//! the frame's origin), both expressed in and about the frame they belong to
//! (`[paper] Eq. (Eq:linear_angular)`, `(Eq:Force_Moment)`, `(Eq:Transformation)`).
//!
//! Twists and wrenches are dual to each other and are different types, so they cannot be mixed.
//! All quantities are SI. Frames are named by suffixes: `V_A` is a twist in frame A, `X_AB` the
//! pose of frame B in frame A.
#![forbid(unsafe_code)]
#![allow(non_snake_case)]

mod inertia;
mod pose;
mod pseudo_inertia;
mod twist;
mod wrench;

pub use inertia::Inertia;
pub use pose::Pose;
pub use pseudo_inertia::PseudoInertia;
pub use twist::Twist;
pub use wrench::Wrench;

use nalgebra::{Matrix3, Vector3};

/// The matrix `[a]×` with `[a]× b = a × b` (`[paper] Eq. (Eq:X_Operator)`).
#[must_use]
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    a.cross_matrix()
}
