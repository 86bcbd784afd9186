//! Checks that an orientation has length 1, for the readers of path files in JSON and CSV.

use crate::error::{PathError, refused};
use nalgebra::{Quaternion, UnitQuaternion};

/// Tolerance of a quaternion's length: files have only a few digits.
const UNIT: f64 = 1e-3;
/// The unit quaternion of w, x, y, z, whose length must be 1.
pub(crate) fn unit(place: &str, [w, x, y, z]: [f64; 4]) -> Result<UnitQuaternion<f64>, PathError> {
    let q = Quaternion::new(w, x, y, z);
    let length = q.norm();
    if (length - 1.0).abs() <= UNIT {
        return Ok(UnitQuaternion::new_normalize(q));
    }
    let rule = format!("a quaternion w, x, y, z of length 1; its length is {length:.4}");
    let given = format!("[{w}, {x}, {y}, {z}]");
    Err(refused(place, "orientation", given, rule))
}
