//! What every control law computes, and from what.

use crate::bodies::Bodies;
use crate::law::decomposition::{self, BodyMotion, VelocityErrors};
use crate::nominal::Nominal;
use crate::tracking::{RequiredMotion, RodMotion};
use hdrm::{Body, Configuration, DOF};
use machine_file::Controller as Gains;

/// From required motion to forces.
pub(crate) trait ControlLaw: Sync {
    /// What rods and wrist joints of the whole machine are to give.
    fn forces(&self, now: &Instant) -> Forces;

    /// What one rod by itself is to give to its load, N; by the model
    /// `f_r = f_d + M_act ẍ_r + K_A (ẋ_r − ẋ)`, `K_A = kappa_KA·M_act`: [Eq:Required_Force] with
    /// the rod as the body.
    fn rod_force(&self, rod: &Rod) -> f64 {
        let lacking = rod.required.x_r_dot - rod.x_dot;
        rod.f_d + rod.M_act * (rod.required.x_r_ddot + rod.gains.kappa_KA * lacking)
    }

    /// Whether the drives compute their currents by the model of the actuator, with its inertia,
    /// friction and what the disturbance observer finds; otherwise by the lossless transmission.
    fn knows_actuators(&self) -> bool {
        true
    }

    /// Advances what the law learns of the bodies by `h` s with these motions held.
    fn learn(
        &self,
        _bodies: &mut Bodies,
        _motions: &[BodyMotion; Body::COUNT],
        _gains: &Gains,
        _h: f64,
    ) {
    }
}

/// The whole machine at one instant.
pub(crate) struct Instant<'a> {
    pub(crate) nominal: &'a Nominal,
    pub(crate) bodies: &'a Bodies,
    pub(crate) gains: &'a Gains,
    pub(crate) configuration: &'a Configuration,
    /// Measured joint rates, rad/s.
    pub(crate) zeta_dot: &'a [f64; DOF],
    pub(crate) required: &'a RequiredMotion,
    /// Required motion of the rods.
    pub(crate) rods: &'a [RodMotion; 3],
    /// Motion of what the machine stands on.
    pub(crate) ground: &'a BodyMotion,
    pub(crate) motions: &'a [BodyMotion; Body::COUNT],
    pub(crate) errors: &'a VelocityErrors,
    /// What the law has integrated, a joint each: see [`Forces::law_integral_rate`].
    pub(crate) law_integral: &'a [f64; DOF],
}

impl Instant<'_> {
    /// Generalised forces of the nominal bodies' required motion, and of the joints' friction, N·m.
    pub(crate) fn model(&self) -> [f64; DOF] {
        let mut Q = self.bodies_forces(0.0);
        for (i, Q) in Q.iter_mut().enumerate() {
            *Q += self.nominal.joint_viscous[i] * self.required.zeta_dot[i];
        }
        Q
    }

    /// Generalised momentum `M s` of the velocity errors with the nominal inertias, N·m·s.
    pub(crate) fn momentum(&self) -> [f64; DOF] {
        let (with, without) = (self.bodies_forces(1.0), self.bodies_forces(0.0));
        std::array::from_fn(|i| with[i] - without[i])
    }

    fn bodies_forces(&self, kappa: f64) -> [f64; DOF] {
        let estimates = &self.bodies.estimates;
        decomposition::joint_forces(
            self.configuration,
            self.motions,
            estimates,
            self.errors,
            kappa,
        )
    }

    /// What these generalised forces, N·m, ask of rods and wrist.
    pub(crate) fn forces_from_joints(&self, Q: [f64; DOF]) -> Forces {
        Forces {
            rods: std::array::from_fn(|i| Q[i] / self.configuration.strokes[i].prime),
            wrist: [Q[3], Q[4], Q[5]],
            law_integral_rate: [0.0; DOF],
        }
    }
}

/// One rod by itself at one instant.
pub(crate) struct Rod<'a> {
    pub(crate) gains: &'a Gains,
    /// Nominal mass that the actuator moves, kg.
    pub(crate) M_act: f64,
    pub(crate) required: &'a RodMotion,
    /// Measured velocity, m/s.
    pub(crate) x_dot: f64,
    /// Desired force on the load, N.
    pub(crate) f_d: f64,
}

/// What a law asks for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forces {
    /// Of the rods, N.
    pub(crate) rods: [f64; 3],
    /// Torques of the wrist joints, N·m, not yet held to their limits.
    pub(crate) wrist: [f64; 3],
    /// Rate of what the law integrates, N·m/s; it rests while a drive or a wrist joint is at its
    /// limit.
    pub(crate) law_integral_rate: [f64; DOF],
}
