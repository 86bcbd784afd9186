//! The gravity vector in the machine's axes, also on a tilted or accelerating base, for the plant
//! and the controller. Its effect on the machine is in [`crate::dynamics::base`].

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Acceleration of gravity in world axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Gravity {
    /// Along −y, m/s².
    pub along_y: f64,
    /// Along x and z, m/s².
    across: [f64; 2],
}

impl Gravity {
    /// From a vector in world axes, m/s².
    pub(crate) fn from_vector([x, y, z]: [f64; 3]) -> Self {
        Self {
            along_y: -y,
            across: [x, z],
        }
    }

    /// The negative gravity vector, m/s², in world axes.
    pub(crate) fn up(&self) -> Vector3<f64> {
        let [x, z] = self.across;
        Vector3::new(-x, self.along_y, -z)
    }

    /// The negative gravity vector without its y component, m/s²; None if that is zero.
    pub(crate) fn sideways(&self) -> Option<Vector3<f64>> {
        let [x, z] = self.across;
        (self.across != [0.0; 2]).then(|| Vector3::new(-x, 0.0, -z))
    }
}

/// Apparent gravity, m/s², on a base with tilt (roll r about x, then pitch p about its own z), rad,
/// and acceleration a, m/s²:
/// ```text
/// g_felt = Rz(p)ᵀ·Rx(r)ᵀ·g − a
/// ```
/// g is in the ground's axes; a and g_felt are in the machine's world axes, which are fixed to the
/// base.
pub fn felt_gravity(g: [f64; 3], [roll, pitch]: [f64; 2], acceleration: [f64; 3]) -> [f64; 3] {
    let ([x, y, z], [a_x, a_y, a_z]) = (g, acceleration);
    let ((s_r, c_r), (s_p, c_p)) = (libm::sincos(roll), libm::sincos(pitch));
    let (y, z) = (c_r * y + s_r * z, c_r * z - s_r * y);
    [c_p * x + s_p * y - a_x, c_p * y - s_p * x - a_y, z - a_z]
}
