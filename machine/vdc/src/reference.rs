//! The reference motion of the tip T4 in the world frame, for `controller`: the paper's
//! trajectories, a path file, an operator's commanded rates, or the inputs.
//!
//! [`Reference`] is immutable; the joints that commanded rates move are a [`Motion`] in the
//! controller's state.

mod desired;
mod edges;
mod external;
mod file;
mod motion;
mod rate_limits;
mod rates;
mod standstill;

pub(crate) use desired::DesiredMotion;
pub(crate) use external::turn_orientation;
pub use motion::CommandHolds;
pub(crate) use motion::Motion;
pub use rate_limits::{RateCommand, RateLimits};
pub(crate) use rates::{Rates, ReferenceBounds, Room, at_any_pose, feedback_at_rest};
pub(crate) use standstill::Standstill;

use crate::error::ControllerError;
use crate::nominal::{Nominal, orientation};
use crate::signals::Input;
use edges::Edges;
use hdrm::Tip;
use machine_file::Machine;
use serde::{Deserialize, Serialize};
use tip_path::{Laps, Load, PathFile, TipPath};

/// The reference that the controller follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trajectory<'a> {
    /// Edges of a cube (the paper's three-dimensional benchmark).
    Cubic,
    /// Triangle in the boom plane.
    Triangular,
    /// Given by the inputs `reference.*`.
    External,
    /// The commanded rates `rate.*`, within these limits.
    Rates(RateLimits),
    /// A path file.
    Path {
        /// The path, which begins at the measured start pose of the tip.
        file: &'a PathFile,
        /// Whether a path that the nominal machine cannot follow is refused.
        is_checked: bool,
    },
}

/// The reference of the tip, or of the joints.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Reference {
    Edges(Edges),
    File(TipPath),
    Rates(Rates),
    External,
}

/// The reference at one instant.
pub(crate) struct Target<'a> {
    pub(crate) tip: DesiredMotion,
    /// Motion of the joints, if the feedback acts on their errors instead of the tip's.
    pub(crate) joints: Option<JointTarget<'a>>,
}

pub(crate) struct JointTarget<'a> {
    pub(crate) motion: &'a Motion,
    /// Largest rates, rad/s, feedback included.
    pub(crate) rate_max: &'a [f64; 6],
}

impl<'a> Target<'a> {
    /// The joints' reference `motion`, without rate limits.
    pub(crate) fn from_joints(motion: &'a Motion, nominal: &Nominal) -> Self {
        Self {
            tip: motion.tip(&nominal.tree),
            joints: Some(JointTarget {
                motion,
                rate_max: &[f64::INFINITY; 6],
            }),
        }
    }
}

impl Reference {
    /// The reference for `trajectory`, starting at the joint angles `zeta`, rad.
    pub(crate) fn new(
        trajectory: Trajectory,
        machine: &Machine,
        nominal: &Nominal,
        zeta: &[f64; 6],
    ) -> Result<Self, ControllerError> {
        let rest = || {
            let tip = Tip::new(&nominal.tree, &nominal.tree.configuration(zeta));
            DesiredMotion::rest(tip.position, orientation(zeta))
        };
        let paths = &machine.trajectories;
        Ok(match trajectory {
            Trajectory::Cubic => Self::Edges(Edges::cubic(&paths.cubic, rest())),
            Trajectory::Triangular => Self::Edges(Edges::triangular(&paths.triangular, rest())),
            Trajectory::External => Self::External,
            Trajectory::Rates(limits) => {
                Self::Rates(Rates::new(machine, &nominal.tree, zeta, &limits)?)
            }
            Trajectory::Path { file, is_checked } => {
                Self::File(file::checked_path(file, is_checked, machine, zeta)?)
            }
        })
    }

    /// The reference `t` s after its start; `motion` is the state of commanded rates.
    pub(crate) fn target<'a>(
        &'a self,
        nominal: &Nominal,
        motion: &'a Motion,
        input: &Input,
        t: f64,
    ) -> Result<Target<'a>, ControllerError> {
        let tip = match self {
            Self::Edges(edges) => edges.at(t),
            Self::File(path) => file::desired_at(path, t),
            Self::Rates(_) => motion.tip(&nominal.tree),
            Self::External => external::desired(input)?,
        };
        let joints = self.rates().map(|rates| JointTarget {
            motion,
            rate_max: rates.largest(),
        });
        Ok(Target { tip, joints })
    }

    /// Duration of the motion, s; None if the inputs determine it.
    pub(crate) fn duration(&self) -> Option<f64> {
        match self {
            Self::Edges(edges) => Some(edges.duration()),
            Self::File(path) => Some(path.duration()),
            Self::Rates(_) | Self::External => None,
        }
    }

    /// Equal laps of the path, if it has some.
    pub(crate) fn laps(&self) -> Option<Laps> {
        match self {
            Self::File(path) => path.laps(),
            _ => None,
        }
    }

    /// Load of the path `t` s after the start of the motion; None if the reference has none.
    #[inline]
    pub(crate) fn load(&self, t: f64) -> Option<Load> {
        match self {
            Self::File(path) => path.load(t),
            _ => None,
        }
    }

    /// The reference by commanded rates; None for another reference.
    pub(crate) fn rates(&self) -> Option<&Rates> {
        match self {
            Self::Rates(rates) => Some(rates),
            _ => None,
        }
    }
}
