//! Mass matrix, bias forces, forward and inverse dynamics, for plant, `motion-check` and studies.

pub(crate) mod base;
pub(crate) mod boom_frame;
pub(crate) mod factor;
pub(crate) mod gravity;
pub(crate) mod recursion;
pub(crate) mod sensitivity;
pub(crate) mod turning;

use crate::DOF;
use crate::dynamics::boom_frame::BoomFrame;
use crate::dynamics::factor::Factor;
use crate::dynamics::gravity::Gravity;
use crate::forces::saturate::saturate;
use crate::geometry::tree::Stroke;
use crate::plant::input::{Input, wrench};
use crate::plant::state::State;
use crate::plant::{Dynamics, Hdrm};
use nalgebra::{Matrix6, Vector6};

impl Hdrm {
    /// Mass matrix and bias forces at a state, on a base at rest.
    pub fn dynamics(&self, state: &State) -> Dynamics {
        self.dynamics_with_gravity(state, self.gravity)
    }

    /// The same on a base that moves with the base inputs of `input`.
    pub fn dynamics_with(&self, state: &State, input: &Input) -> Dynamics {
        let mut dynamics = self.dynamics_with_gravity(state, self.felt_gravity(input));
        if let Some(turning) = self.turning_forces(state, input) {
            dynamics.h += turning;
        }
        dynamics
    }

    fn dynamics_with_gravity(&self, state: &State, gravity: Gravity) -> Dynamics {
        let State { zeta, zeta_dot, .. } = state;
        let solved = self.tree.solve(zeta);
        let frame = BoomFrame::new(&self.tree, &self.parts, &solved);
        let (M, momentum_y) = frame.mass_matrix();
        let mut h = frame.bias(zeta_dot, gravity.along_y);
        let mut holding = momentum_y * gravity.along_y;
        if let Some(sideways) = self.holding_sideways(&gravity, zeta) {
            h += sideways;
            holding += sideways;
        }
        Dynamics {
            state: *state,
            gravity,
            strokes: self.tree.strokes(zeta[0], &solved),
            factor: Factor::new(&M),
            M,
            h,
            momentum_y,
            holding,
            frame,
        }
    }

    /// Mass matrix `M` and bias `h` with gravity, without friction and stops.
    pub fn equations_of_motion(&self, state: &State) -> (Matrix6<f64>, Vector6<f64>) {
        let Dynamics { M, h, .. } = self.dynamics(state);
        (M, h)
    }

    /// Joint accelerations, rad/s².
    pub fn forward_dynamics(&self, state: &State, input: &Input) -> [f64; DOF] {
        self.acceleration(&self.dynamics_with(state, input), input)
            .into()
    }

    /// `M⁻¹·(Q − h − D·zeta_dot)`.
    pub(crate) fn acceleration(&self, dynamics: &Dynamics, input: &Input) -> Vector6<f64> {
        let Q = self.generalised_forces(dynamics, input);
        dynamics.factor.solve(&(Q - dynamics.h))
    }

    /// Generalised forces of drives, end stops, friction, environment and contact, N·m.
    pub(crate) fn generalised_forces(&self, dynamics: &Dynamics, input: &Input) -> Vector6<f64> {
        let State { zeta, zeta_dot, .. } = &dynamics.state;
        let mut Q = dynamics.frame.tip_forces(&wrench(&input.wrench_env));
        if self.plane.is_some() {
            Q += dynamics
                .frame
                .world_force_at_tip(&self.contact_force(dynamics).force);
        }
        for i in 0..DOF {
            let w = zeta_dot[i];
            Q[i] -= self.joint_viscous[i] * w + self.joint_dry.torque(i, w).0;
            Q[i] += if i < 3 {
                let Stroke { x, prime, .. } = dynamics.strokes[i];
                prime * (input.f[i] + self.stops[i].force(x, prime * w))
            } else {
                self.wrist_torque(&dynamics.state, i - 3, input) + self.stops[i].force(zeta[i], w)
            };
        }
        Q
    }

    /// Torque of wrist drive i: an ideal source follows the command up to its limit, and its brake
    /// holds the joint; a drive as built transmits the torque of its gear.
    fn wrist_torque(&self, state: &State, i: usize, input: &Input) -> f64 {
        let drive = &state.wrist[i];
        if self.wrist.is_some() {
            return drive.transmitted;
        }
        let tau = self.wrist_command(input, i);
        if !drive.holds {
            return tau;
        }
        tau + self.anchors[i].torque(drive, [state.zeta[3 + i], state.zeta_dot[3 + i]])
    }

    /// Commanded torque of wrist drive i, up to its limit; 0 while it is off.
    pub(crate) fn wrist_command(&self, input: &Input, i: usize) -> f64 {
        match input.wrist_enable[i] {
            true => saturate(input.tau_wrist[i], self.tau_wrist_max[i]),
            false => 0.0,
        }
    }

    /// Derivative of the wrist torque by its command: 1, or 0 in saturation, off and as built.
    pub(crate) fn wrist_gain(&self, i: usize, input: &Input) -> f64 {
        let follows = input.wrist_enable[i] && input.tau_wrist[i].abs() <= self.tau_wrist_max[i];
        f64::from(u8::from(self.wrist.is_none() && follows))
    }

    /// Inverse dynamics: rod forces and wrist torques for the accelerations `zeta_ddot`, rad/s²,
    /// under the wrench `wrench_env` on the tip, without end stops and torque limits. Independent
    /// of the implementation of [`Hdrm::forward_dynamics`].
    pub fn inverse_dynamics(
        &self,
        state: &State,
        zeta_ddot: &[f64; DOF],
        wrench_env: &[f64; 6],
    ) -> ([f64; 3], [f64; 3]) {
        let State { zeta, zeta_dot, .. } = state;
        let configuration = self.tree.configuration(zeta);
        let mut Q = recursion::inverse_dynamics(
            &configuration,
            &self.bodies,
            zeta_dot,
            zeta_ddot,
            &self.gravity,
        )
        .value;
        Q += Vector6::from(self.joint_viscous).component_mul(&Vector6::from(*zeta_dot));
        Q += Vector6::from_fn(|i, _| self.joint_dry.torque(i, zeta_dot[i]).0);
        let W = wrench(wrench_env);
        Q -= recursion::tip_forces(&configuration, &self.tree, zeta_dot, &W).value;
        let f = std::array::from_fn(|i| Q[i] / configuration.strokes[i].prime);
        (f, [Q[3], Q[4], Q[5]])
    }

    /// Rod forces, N, and wrist torques, N·m, that hold the pose `zeta` against gravity.
    pub fn holding(&self, zeta: &[f64; DOF]) -> ([f64; 3], [f64; 3]) {
        self.inverse_dynamics(&State::at_rest(*zeta), &[0.0; DOF], &[0.0; 6])
    }

    /// Kinetic and potential energy, J; the latter is relative to the world's origin.
    pub fn energies(&self, state: &State) -> (f64, f64) {
        self.energies_at(&self.dynamics(state))
    }

    pub(crate) fn energies_at(&self, dynamics: &Dynamics) -> (f64, f64) {
        let w = Vector6::from(dynamics.state.zeta_dot);
        let kinetic = 0.5 * w.dot(&(dynamics.M * w));
        let along_y = dynamics.gravity.along_y * dynamics.frame.first_moment_y();
        let sideways = self.potential_sideways(&dynamics.gravity, &dynamics.state.zeta);
        (kinetic, along_y + sideways)
    }
}
