//! Forward kinematics of the tip, for reference, tracking and the start values of the FMU.

use hdrm::{GeometryError, Tip, Tree};
use machine_file::Machine;
use nalgebra::UnitQuaternion;

/// Tip position (m) and orientation (quaternion w, x, y, z) at the joint angles `zeta`, rad.
pub fn tip_pose(machine: &Machine, zeta: &[f64; 6]) -> Result<([f64; 3], [f64; 4]), GeometryError> {
    let tree = Tree::new(machine)?;
    let tip = Tip::new(&tree, &tree.configuration(zeta));
    let q = orientation(zeta);
    Ok((tip.position.into(), [q.w, q.i, q.j, q.k]))
}

/// Orientation of the tip at the joint angles `zeta`, rad.
pub(crate) fn orientation(zeta: &[f64; 6]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Tip::orientation(zeta))
}
