//! A path of a file as the reference.

use crate::error::ControllerError;
use crate::reference::desired::DesiredMotion;
use machine_file::Machine;
use motion_check::Kinematics;
use nalgebra::Vector6;
use tip_path::{PathFile, TipPath, check};

/// The path of `file` from where the joint angles `zeta`, rad, have the tip. With `is_checked` the
/// path is refused where the nominal machine cannot do it.
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
