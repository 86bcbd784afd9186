//! What the tip is to do: the paper's trajectories, a path of a file, an operator's commanded
//! rates, or what the inputs say.
//!
//! Position, velocity and acceleration of T4 in the world frame. [`Reference`] is immutable; what
//! moves of it, the joints of commanded rates, is a [`Motion`] of the controller's state.

mod desired;
mod edges;
mod external;
mod file;
mod motion;
mod rate_limits;
mod rates;

pub(crate) use desired::DesiredMotion;
pub(crate) use external::turn_orientation;
pub use motion::CommandHolds;
pub(crate) use motion::Motion;
pub use rate_limits::{RateCommand, RateLimits};
pub(crate) use rates::Rates;

use crate::error::ControllerError;
use crate::nominal::{Nominal, orientation};
use crate::signals::Input;
use edges::Edges;
use hdrm::Tip;
use machine_file::Machine;
use serde::{Deserialize, Serialize};
use tip_path::{Load, PathFile, TipPath};

/// Which desired motion the controller follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trajectory<'a> {
    /// Edges of a cube (the paper's three-dimensional benchmark).
    Cubic,
    /// Triangle in the boom plane.
    Triangular,
    /// Given by the inputs `reference.*`.
    External,
    /// Made of the commanded rates `rate.*`, within these limits.
    Rates(RateLimits),
    /// Given as a file.
    Path {
        /// The path, which begins where the tip is measured at the start.
        file: &'a PathFile,
        /// Whether a path is refused that the nominal machine cannot do.
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

/// What is to be followed at one instant.
pub(crate) struct Target<'a> {
    /// Of the tip.
    pub(crate) tip: DesiredMotion,
    /// Of the joints, where the feedback acts on their errors instead of the tip's.
    pub(crate) joints: Option<JointTarget<'a>>,
}

/// The joints' reference.
pub(crate) struct JointTarget<'a> {
    pub(crate) motion: &'a Motion,
    /// Largest rates, rad/s, feedback included.
    pub(crate) rate_max: &'a [f64; 6],
}

impl<'a> Target<'a> {
    /// The joints' reference `motion`, whatever rates it takes.
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
    /// The reference that `trajectory` names, from the joint angles `zeta`, rad.
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

    /// What is to be followed `t` s after the reference began to move, where the joints of
    /// commanded rates are at `motion` and the inputs say `input`.
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

    /// Time from the beginning of the motion to its end, s; None for one that the inputs give.
    pub(crate) fn duration(&self) -> Option<f64> {
        match self {
            Self::Edges(edges) => Some(edges.duration()),
            Self::File(path) => Some(path.duration()),
            Self::Rates(_) | Self::External => None,
        }
    }

    /// What the end-effector carries `t` s after the beginning of the motion; None where the
    /// reference says nothing of loads.
    #[inline]
    pub(crate) fn load(&self, t: f64) -> Option<Load> {
        match self {
            Self::File(path) => path.load(t),
            _ => None,
        }
    }

    /// How commanded rates move the joints; None for another reference.
    pub(crate) fn rates(&self) -> Option<&Rates> {
        match self {
            Self::Rates(rates) => Some(rates),
            _ => None,
        }
    }
}
