//! Converts rotation vectors to quaternions and back, bit-identically, for `tip-path` and `vdc`.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// The rotation about a vector's direction by its length, rad.
#[inline]
pub fn turn(rotation: Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = rotation.norm();
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let per_angle = if angle > 0.0 { sine / angle } else { 0.5 };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, rotation * per_angle))
}

/// Rotation vector of `q`, at most half a turn, rad.
#[inline]
pub fn rotation_vector(q: &UnitQuaternion<f64>) -> Vector3<f64> {
    let sine = q.imag().norm();
    if sine == 0.0 {
        return Vector3::zeros();
    }
    q.imag() * (2.0 * q.w.signum() * libm::atan2(sine, q.w.abs()) / sine)
}
