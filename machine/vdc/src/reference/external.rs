//! The reference from the inputs `reference.*`, and its orientation ahead for the prediction.

use crate::error::ControllerError;
use crate::reference::desired::DesiredMotion;
use crate::signals::Input;
use motion_check::turn;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// The tip's motion from the inputs `reference.*`; an error for a quaternion shorter than 1e-3.
pub(crate) fn desired(input: &Input) -> Result<DesiredMotion, ControllerError> {
    let [w, x, y, z] = input.reference_orientation;
    let q = Quaternion::new(w, x, y, z);
    let orientation =
        UnitQuaternion::try_new(q, 1e-3).ok_or(ControllerError::Orientation { norm: q.norm() })?;
    Ok(DesiredMotion {
        position: input.reference_position.into(),
        velocity: input.reference_velocity.into(),
        acceleration: input.reference_acceleration.into(),
        orientation,
        angular_velocity: input.reference_angular_velocity.into(),
    })
}

/// The inputs' orientation `h` s ahead at their angular velocity, for the prediction over a delay.
pub(crate) fn turn_orientation(input: &Input, h: f64) -> [f64; 4] {
    let [w, x, y, z] = input.reference_orientation;
    let turn = turn(Vector3::from(input.reference_angular_velocity) * h);
    let q = turn.into_inner() * Quaternion::new(w, x, y, z);
    [q.w, q.i, q.j, q.k]
}
