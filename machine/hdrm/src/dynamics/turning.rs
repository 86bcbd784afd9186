//! Coriolis, centrifugal and Euler forces on the bodies of a machine whose base rotates, for
//! `dynamics`, `output` and `sensitivity`; the wrench on the base, for tests.
//!
//! The world frame is fixed to the base, so joint angles and rates are relative to it, and the mass
//! matrix is unchanged. The additional bias forces are the difference of two recursions, one with
//! the ground moving with `V = [0; Ω]`, `V̇ = [0; Ω̇]` and one at rest, if the base rotates.

use crate::dynamics::recursion::{self, Ground, WithRate};
use crate::plant::input::{Input, wrench};
use crate::plant::state::State;
use crate::plant::{Dynamics, Hdrm};
use crate::{Configuration, DOF};
use nalgebra::{Vector3, Vector6};
use spatial::{Twist, Wrench};

/// Rotation of the base, in its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BaseRotation {
    /// Ω, rad/s.
    w: Vector3<f64>,
    /// Ω̇, rad/s².
    w_dot: Vector3<f64>,
}

impl BaseRotation {
    /// None while the base does not rotate.
    #[inline(always)]
    fn from_input(input: &Input) -> Option<Self> {
        let (w, w_dot) = (input.base_angular_velocity, input.base_angular_acceleration);
        ((w, w_dot) != ([0.0; 3], [0.0; 3])).then(|| Self {
            w: w.into(),
            w_dot: w_dot.into(),
        })
    }

    /// The ground's motion; `w_ddot` is the rate of Ω̇, rad/s³.
    fn ground(&self, w_ddot: Vector3<f64>) -> Ground {
        let turn = |w| Twist::new(Vector3::zeros(), w);
        Ground {
            V: turn(self.w),
            A: turn(self.w_dot),
            A_dot: turn(w_ddot),
        }
    }
}

impl Hdrm {
    /// Generalised forces due to the base's rotation, N·m; None while it does not rotate. They do
    /// not depend on the joint accelerations.
    #[inline(always)]
    pub(crate) fn turning_forces(&self, state: &State, input: &Input) -> Option<Vector6<f64>> {
        let turning = BaseRotation::from_input(input)?;
        Some(self.forces_of_turning(
            &turning,
            &self.tree.configuration(&state.zeta),
            &state.zeta_dot,
        ))
    }

    #[cold]
    #[inline(never)]
    fn forces_of_turning(
        &self,
        turning: &BaseRotation,
        configuration: &Configuration,
        zeta_dot: &[f64; DOF],
    ) -> Vector6<f64> {
        let ground = turning.ground(Vector3::zeros());
        self.moving_minus_resting(&ground, configuration, zeta_dot, &[0.0; DOF])
            .value
    }

    /// Inertial forces on the moving ground minus those at rest, and their rate for `zeta_ddot`.
    fn moving_minus_resting(
        &self,
        ground: &Ground,
        configuration: &Configuration,
        zeta_dot: &[f64; DOF],
        zeta_ddot: &[f64; DOF],
    ) -> WithRate<Vector6<f64>> {
        let [moving, resting] = [*ground, Ground::default()].map(|ground| {
            recursion::inertial_forces(configuration, &self.bodies, zeta_dot, zeta_ddot, &ground).0
        });
        WithRate {
            value: moving.value - resting.value,
            rate: moving.rate - resting.rate,
        }
    }

    /// Directional derivative of [`Hdrm::turning_forces`] along `seed` of the input at constant
    /// state, by a central difference, which is exact as they are quadratic in Ω and Ω̇.
    pub(crate) fn turning_change(
        &self,
        state: &State,
        input: &Input,
        seed: &Input,
    ) -> Option<Vector6<f64>> {
        let change = BaseRotation::from_input(seed)?;
        let configuration = self.tree.configuration(&state.zeta);
        let aside = |sign: f64| {
            let turning = BaseRotation {
                w: Vector3::from(input.base_angular_velocity) + change.w * sign,
                w_dot: Vector3::from(input.base_angular_acceleration) + change.w_dot * sign,
            };
            self.forces_of_turning(&turning, &configuration, &state.zeta_dot)
        };
        Some((aside(1.0) - aside(-1.0)) * 0.5)
    }

    /// Rate of [`Hdrm::turning_forces`] with `zeta_ddot` and the input rates `input_dot`.
    pub(crate) fn turning_rate(
        &self,
        state: &State,
        configuration: &Configuration,
        zeta_ddot: &[f64; DOF],
        input: &Input,
        input_dot: &Input,
    ) -> Vector6<f64> {
        let Some(turning) = BaseRotation::from_input(input) else {
            let change = self.turning_change(state, input, input_dot);
            return change.unwrap_or_default();
        };
        // First as if the rate of Ω were Ω̇, then the deviation of the given rate from it.
        let ground = turning.ground(input_dot.base_angular_acceleration.into());
        let WithRate { rate, .. } =
            self.moving_minus_resting(&ground, configuration, &state.zeta_dot, zeta_ddot);
        let w_dot = Vector3::from(input_dot.base_angular_velocity);
        let seed = Input {
            base_angular_velocity: (w_dot - turning.w_dot).into(),
            ..Input::default()
        };
        let otherwise = self.turning_change(state, input, &seed);
        rate + otherwise.unwrap_or_default()
    }

    /// Force (N) and moment (N·m) `[f; m]` of the base on the machine, in and about the world
    /// frame, which is fixed to the base.
    pub fn base_wrench(&self, state: &State, input: &Input) -> [f64; 6] {
        let dynamics = self.dynamics_with(state, input);
        let zeta_ddot = self.acceleration(&dynamics, input).into();
        let configuration = self.tree.configuration(&state.zeta);
        let ground = BaseRotation::from_input(input)
            .map_or_else(Ground::default, |turning| turning.ground(Vector3::zeros()));
        let inertial = recursion::inertial_forces(
            &configuration,
            &self.bodies,
            &state.zeta_dot,
            &zeta_ddot,
            &ground,
        );
        let up = dynamics.gravity.up();
        let poses = configuration.world_poses();
        let weight = self
            .bodies
            .iter()
            .zip(&poses)
            .fold(Wrench::zero(), |sum, (body, pose)| {
                let h = pose.R * body.h + pose.r * body.m;
                sum + Wrench::new(up * body.m, h.cross(&up))
            });
        (inertial.1 + weight - self.outer_wrench(&dynamics, input))
            .to_vector()
            .into()
    }

    /// Wrench of environment and contact on the tip, in and about the world frame.
    fn outer_wrench(&self, dynamics: &Dynamics, input: &Input) -> Wrench {
        let configuration = self.tree.configuration(&dynamics.state.zeta);
        let tip = configuration.world_poses()[crate::Body::D4 as usize]
            * spatial::Pose::translation(self.tree.r_D4_T4);
        let touch = self.contact_force(dynamics).force;
        let at_tip = wrench(&input.wrench_env);
        tip.wrench_to_A(&at_tip) + Wrench::new(touch, tip.r.cross(&touch))
    }
}
