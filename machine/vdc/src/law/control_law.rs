//! The interface of a control law for `controller` and `drive`: its inputs, forces and adaptation.

use crate::bodies::Bodies;
use crate::law::decomposition::{self, BodyMotion, VelocityErrors};
use crate::nominal::Nominal;
use crate::tracking::{RequiredMotion, RodMotion};
use hdrm::{Body, Configuration, DOF};
use machine_file::Controller as Gains;

/// Computes forces from the required motion.
pub(crate) trait ControlLaw: Sync {
    /// Required forces of rods and wrist joints of the whole machine.
    fn forces(&self, now: &Instant) -> Forces;

    /// Required force of a single rod on its load, N; by the model
    /// `f_r = f_d + M_act ẍ_r + K_A (ẋ_r − ẋ)`, `K_A = kappa_KA·M_act`: [Eq:Required_Force] with
    /// the rod as the body.
    fn rod_force(&self, rod: &Rod) -> f64 {
        let lacking = rod.required.x_r_dot - rod.x_dot;
        rod.f_d + rod.M_act * (rod.required.x_r_ddot + rod.gains.kappa_KA * lacking)
    }

    /// Whether the required currents include the actuator's inertia, friction and the disturbance
    /// observer; otherwise they follow from the lossless transmission.
    fn knows_actuators(&self) -> bool {
        true
    }

    /// Whether the friction of the wrist is estimated and fed forward, which an integral of the law's
    /// own would oppose.
    fn compensates_friction(&self) -> bool {
        false
    }

    /// Whether the estimates of the bodies adapt; else errors of the joints' rates carry what they lack.
    fn adapts(&self) -> bool {
        false
    }

    /// Adapts the estimates of the bodies by `h` s with these motions held.
    fn learn(
        &self,
        _bodies: &mut Bodies,
        _motions: &[BodyMotion; Body::COUNT],
        _gains: &Gains,
        _h: f64,
    ) {
    }
}

/// The whole machine at one instant, the input of a control law.
pub(crate) struct Instant<'a> {
    pub(crate) nominal: &'a Nominal,
    pub(crate) bodies: &'a Bodies,
    pub(crate) gains: &'a Gains,
    pub(crate) configuration: &'a Configuration,
    /// Measured joint rates, rad/s.
    pub(crate) zeta_dot: &'a [f64; DOF],
    pub(crate) required: &'a RequiredMotion,
    pub(crate) rods: &'a [RodMotion; 3],
    pub(crate) ground: &'a BodyMotion,
    pub(crate) motions: &'a [BodyMotion; Body::COUNT],
    pub(crate) errors: &'a VelocityErrors,
    /// Momentum of these errors where joints have shares of their own ([`decomposition::shared_momentum`]).
    pub(crate) shared_momentum: Option<[f64; DOF]>,
    /// The law's integral for each joint: see [`Forces::law_integral_rate`].
    pub(crate) law_integral: &'a [f64; DOF],
}

impl Instant<'_> {
    /// Generalised forces of the nominal model for the required motion, with friction, N·m.
    pub(crate) fn model(&self) -> [f64; DOF] {
        let mut Q = self.bodies_forces(0.0);
        for (i, Q) in Q.iter_mut().enumerate() {
            *Q += self.nominal.joint_viscous[i] * self.required.zeta_dot[i];
        }
        Q
    }

    /// Generalised forces of the bodies with the feedback `K_A s`, N·m.
    pub(crate) fn bodies_with_feedback(&self) -> [f64; DOF] {
        let kappa = self.gains.kappa_KA;
        let Some(momentum) = self.shared_momentum else {
            return self.bodies_forces(kappa);
        };
        let Q = self.bodies_forces(0.0);
        std::array::from_fn(|i| Q[i] + kappa * momentum[i])
    }

    /// Generalised momentum of the velocity errors with the nominal inertias, N·m·s, of which the
    /// shares of the joints count: `√S M √S s`.
    pub(crate) fn momentum(&self) -> [f64; DOF] {
        if let Some(momentum) = self.shared_momentum {
            return momentum;
        }
        let (with, without) = (self.bodies_forces(1.0), self.bodies_forces(0.0));
        std::array::from_fn(|i| with[i] - without[i])
    }

    /// Power that the feedback `K_A s` takes out, `sᵀ K_A s`, W.
    pub(crate) fn dissipation(&self) -> f64 {
        let kappa = self.gains.kappa_KA;
        let Some(momentum) = self.shared_momentum else {
            return 2.0 * kappa * self.errors.energy;
        };
        let powers = momentum.iter().enumerate();
        kappa * powers.map(|(i, p)| p * self.rate_error(i)).sum::<f64>()
    }

    /// Error `s` of a joint's rate, rad/s.
    pub(crate) fn rate_error(&self, i: usize) -> f64 {
        self.required.zeta_dot[i] - self.zeta_dot[i]
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

    /// Rod forces and wrist torques for these generalised forces, N·m.
    pub(crate) fn forces_from_joints(&self, Q: [f64; DOF]) -> Forces {
        Forces {
            rods: std::array::from_fn(|i| Q[i] / self.configuration.strokes[i].prime),
            wrist: [Q[3], Q[4], Q[5]],
            law_integral_rate: [0.0; DOF],
        }
    }
}

/// A single rod at one instant, without the machine.
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

/// Result of a control law.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forces {
    /// Forces of the rods, N.
    pub(crate) rods: [f64; 3],
    /// Torques of the wrist joints before saturation, N·m.
    pub(crate) wrist: [f64; 3],
    /// Rate of the law's integral, N·m/s; frozen while a drive or wrist joint is at its limit.
    pub(crate) law_integral_rate: [f64; DOF],
}
