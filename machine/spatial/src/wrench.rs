//! Wrenches for plant and controller: a force with a moment on a rigid body, or its momentum.

use crate::pair::pair_of_vectors;
use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// A wrench `[f; m]` in and about some frame A (`[paper] Eq. (Eq:Force_Moment)`); also a spatial
/// momentum (linear, angular about the origin).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub f: Vector3<f64>,
    /// Moment about the frame's origin, N·m.
    pub m: Vector3<f64>,
}

pair_of_vectors!(Wrench: f m, zero: "No force, no moment.");
