//! The paper's control laws, the modes `modular` and `adaptive`: forces from the rigid-body model,
//! with nominal inertias or with adapted estimates.

use crate::bodies::{Bodies, adaptation_direction};
use crate::law::control_law::{ControlLaw, Forces, Instant};
use crate::law::decomposition::BodyMotion;
use hdrm::Body;
use machine_file::Controller as Gains;

/// Virtual decomposition control.
pub(crate) struct ModelBased {
    /// Whether the estimates of the inertias adapt ([L adapt]); otherwise they stay nominal.
    pub(crate) adapts: bool,
}

impl ControlLaw for ModelBased {
    /// The required wrenches of the bodies, projected on the joints, and the joints' friction.
    fn forces(&self, now: &Instant) -> Forces {
        let mut Q = now.bodies_with_feedback();
        for (i, Q) in Q.iter_mut().enumerate() {
            *Q += now.nominal.joint_viscous[i] * now.required.zeta_dot[i];
        }
        now.forces_from_joints(Q)
    }

    fn compensates_friction(&self) -> bool {
        true
    }

    fn adapts(&self) -> bool {
        self.adapts
    }

    fn learn(
        &self,
        bodies: &mut Bodies,
        motions: &[BodyMotion; Body::COUNT],
        gains: &Gains,
        h: f64,
    ) {
        if !self.adapts {
            return;
        }
        for (k, motion) in motions.iter().enumerate() {
            let S = adaptation_direction(&motion.w, &motion.V_r, &motion.V, &motion.s());
            let bounds = &bodies.bounds[k];
            bodies.estimates[k].advance(&S, gains.gamma, gains.leakage, h, bounds);
        }
    }
}
