//! The plant's configuration, and the terms of its equations at one state, for steps and outputs.

pub(crate) mod assembly;
pub(crate) mod brakes;
pub(crate) mod continuous;
pub(crate) mod error;
pub(crate) mod input;
pub(crate) mod options;
pub(crate) mod output;
pub(crate) mod state;
pub(crate) mod step;

use crate::DOF;
use crate::dynamics::boom_frame::{BoomFrame, MovingParts};
use crate::dynamics::factor::Factor;
use crate::dynamics::gravity::Gravity;
use crate::forces::contact::Plane;
use crate::forces::dry_friction::DryFriction;
use crate::forces::end_stop::EndStop;
use crate::forces::wrist_brake::{Anchor, WristBrake};
use crate::forces::wrist_drive::WristDrive;
use crate::geometry::body::Body;
use crate::geometry::tree::{Stroke, Tree};
use crate::load::{Load, Payload};
use crate::plant::state::State;
use nalgebra::{Matrix6, Vector6};
use serde::{Deserialize, Serialize};
use spatial::Inertia;

/// The manipulator; its parameters are constant except the load ([`Hdrm::change_load`]).
///
/// ```text
/// M(zeta)·zeta_ddot + h(zeta, zeta_dot) + D·zeta_dot + friction(zeta_dot)
///     = Jxᵀ·(f + f_stop) + [0, 0, 0, tau + tau_stop] + J_T4ᵀ·(W_env + W_contact)
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hdrm {
    pub(crate) tree: Tree,
    /// In the order of [`crate::BODIES`].
    pub(crate) bodies: [Inertia; Body::COUNT],
    pub(crate) parts: MovingParts,
    pub(crate) payload: Payload,
    pub(crate) load: Load,
    pub(crate) plane: Option<Plane>,
    pub(crate) gravity: Gravity,
    pub(crate) joint_viscous: [f64; DOF],
    /// Whether the number of substeps may depend on friction.
    pub(crate) friction_is_stiff: bool,
    pub(crate) joint_dry: DryFriction,
    pub(crate) tau_wrist_max: [f64; 3],
    /// None: ideal torque sources.
    pub(crate) wrist: Option<WristDrive>,
    pub(crate) brake: WristBrake,
    /// How the brakes hold the joints of ideal drives.
    pub(crate) anchors: [Anchor; 3],
    /// Of the strokes of slew, lift and tilt, then of the wrist angles.
    pub(crate) stops: [EndStop; DOF],
}

/// The plant at one state, without what depends on the inputs.
#[derive(Clone, Debug)]
pub struct Dynamics {
    pub(crate) state: State,
    /// Apparent gravity on the base.
    pub(crate) gravity: Gravity,
    pub(crate) frame: BoomFrame,
    pub(crate) strokes: [Stroke; 3],
    pub(crate) M: Matrix6<f64>,
    pub(crate) factor: Factor,
    /// Bias forces with gravity.
    pub(crate) h: Vector6<f64>,
    /// The machine's momentum along y for each coordinate's unit rate, kg·m.
    pub(crate) momentum_y: Vector6<f64>,
    /// Generalised forces that hold the machine against gravity.
    pub(crate) holding: Vector6<f64>,
}

impl Hdrm {
    /// The plant's geometry.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Inertias in the order of [`crate::BODIES`], in body axes about body origins.
    pub fn inertias(&self) -> &[Inertia; Body::COUNT] {
        &self.bodies
    }

    /// End stops of the strokes of slew, lift and tilt (m), then of the wrist angles (rad).
    pub fn end_stops(&self) -> &[EndStop; DOF] {
        &self.stops
    }
}
