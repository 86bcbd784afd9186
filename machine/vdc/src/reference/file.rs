//! A path file as the reference, for `reference`: plans the path, checks it, and evaluates it.

use crate::error::ControllerError;
use crate::reference::desired::DesiredMotion;
use machine_file::Machine;
use motion_check::Kinematics;
use nalgebra::Vector6;
use tip_path::{PathFile, TipPath, check};

/// Plans the path of `file` from the tip's pose at the joint angles `zeta`, rad. With `is_checked`
/// an error if the nominal machine cannot follow it.
pub(crate) fn checked_path(
    file: &PathFile,
    is_checked: bool,
    machine: &Machine,
    zeta: &[f64; 6],
) -> Result<TipPath, ControllerError> {
    let start = Kinematics::new(machine)?.pose(zeta);
    let path = TipPath::new(file, start)?;
    if is_checked {
        let checked = check(file, &path, machine, zeta, |_, _| ())?;
        if let Some(refusal) = checked.refusal() {
            return Err(ControllerError::Refused(refusal));
        }
    }
    Ok(path)
}

/// The motion of a path at `t`, s.
pub(crate) fn desired_at(path: &TipPath, t: f64) -> DesiredMotion {
    let motion = path.at(t);
    let linear = |v: &Vector6<f64>| v.fixed_rows::<3>(0).into();
    DesiredMotion {
        position: motion.pose.position,
        velocity: linear(&motion.velocity),
        acceleration: linear(&motion.acceleration),
        orientation: motion.pose.orientation,
        angular_velocity: motion.velocity.fixed_rows::<3>(3).into(),
    }
}
