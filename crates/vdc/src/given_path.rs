//! A path of a file as the reference.

use crate::reference::Desired;
use crate::{Controller, ControllerError, Input, Settings};
use capability::Kinematics;
use machine::Machine;
use tip_path::{PathFile, TipPath, check};

impl Controller {
    /// The same controller following the path of `file` from where `input` measures the tip; before its first step. With `is_checked` the
    /// path is refused where the nominal machine cannot do it.
    ///
    /// # Errors
    /// Times of arrival that the path's own limits do not allow; what the machine cannot do, where and by how much.
    pub fn following(
        mut self,
        file: &PathFile,
        machine: &Machine,
        settings: &Settings,
        input: &Input,
        is_checked: bool,
    ) -> Result<Self, ControllerError> {
        let start = Kinematics::new(machine)?.pose(&input.zeta);
        let path = TipPath::new(file, start)?;
        if is_checked {
            let checked = check(file, &path, machine, &input.zeta, |_, _| ())?;
            if let Some(refusal) = checked.refusal() {
                return Err(ControllerError::Refused(refusal));
            }
        }
        (self.path, self.given) = (None, Some(path));
        self.settle(settings, input)?;
        Ok(self)
    }

    /// Time since the reference began to move, s; negative before.
    pub(crate) fn path_time(&self, settings: &Settings) -> f64 {
        self.state.t - self.state.t_start - settings.gains.settle_time
    }
}

/// The motion of a path at `t`, s.
pub(crate) fn given_at(path: &TipPath, t: f64) -> Desired {
    let motion = path.at(t);
    let linear = |v: &nalgebra::Vector6<f64>| v.fixed_rows::<3>(0).into();
    Desired {
        position: motion.pose.position,
        velocity: linear(&motion.velocity),
        acceleration: linear(&motion.acceleration),
        orientation: motion.pose.orientation,
        angular_velocity: motion.velocity.fixed_rows::<3>(3).into(),
    }
}
