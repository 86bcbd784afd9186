//! Exact derivatives of the joint accelerations with respect to the inputs and to time, from which
//! the FMU `Hdrm` answers calls for directional derivatives and output derivatives.

use crate::dynamics::recursion;
use crate::plant::input::{Input, wrench};
use crate::plant::state::State;
use crate::plant::{Dynamics, Hdrm};
use crate::{Configuration, DOF, Output, Stroke};
use nalgebra::Vector6;

impl Hdrm {
    /// Directional derivative of the outputs for a change `seed` of the input at constant state:
    /// `δzeta_ddot = M⁻¹·(Jxᵀ·δf + δtau + J_T4ᵀ·δW − δQ_hold − δQ_turning)`, and for base inputs
    /// also holding forces and potential energy.
    pub fn directional_derivative(&self, state: &State, input: &Input, seed: &Input) -> Output {
        let dynamics = self.dynamics_with(state, input);
        let mut Q = self.drive_forces(&dynamics, input, seed);
        let mut change = Output::default();
        if let Some(g_change) = self.felt_gravity_rate(input, seed) {
            let configuration = self.tree.configuration(&state.zeta);
            let holding = self.holding_rate(&dynamics, &configuration, g_change);
            Q -= holding;
            change.f_hold = std::array::from_fn(|i| holding[i] / dynamics.strokes[i].prime);
            change.tau_hold = std::array::from_fn(|i| holding[3 + i]);
            change.energy_potential = self.potential_rate(&configuration, g_change);
        }
        if let Some(turning) = self.turning_change(state, input, seed) {
            Q -= turning;
        }
        Output {
            zeta_ddot: dynamics.factor.solve(&Q).into(),
            ..change
        }
    }

    /// Generalised forces of a change `seed` of forces, torques and tip wrench.
    fn drive_forces(&self, dynamics: &Dynamics, input: &Input, seed: &Input) -> Vector6<f64> {
        let mut Q = dynamics.frame.tip_forces(&wrench(&seed.wrench_env));
        for i in 0..3 {
            Q[i] += dynamics.strokes[i].prime * seed.f[i];
            Q[3 + i] += self.wrist_gain(i, input) * seed.tau_wrist[i];
        }
        Q
    }

    /// `zeta_dddot = M⁻¹·(Q_dot − M_dot·zeta_ddot − h_dot − D·zeta_ddot)`, rad/s³; the middle terms
    /// come from the recursion.
    pub(crate) fn acceleration_rate(
        &self,
        dynamics: &Dynamics,
        configuration: &Configuration,
        zeta_ddot: &[f64; DOF],
        input: &Input,
        input_dot: &Input,
    ) -> Vector6<f64> {
        let State { zeta, zeta_dot, .. } = &dynamics.state;
        let inertial = recursion::inverse_dynamics(
            configuration,
            &self.bodies,
            zeta_dot,
            zeta_ddot,
            &dynamics.gravity,
        );
        let tip = recursion::tip_forces(
            configuration,
            &self.tree,
            zeta_dot,
            &wrench(&input.wrench_env),
        );
        let mut Q_dot = self.drive_forces(dynamics, input, input_dot) + tip.rate - inertial.rate;
        Q_dot -= self.turning_rate(&dynamics.state, configuration, zeta_ddot, input, input_dot);
        if let Some(g_dot) = self.felt_gravity_rate(input, input_dot) {
            Q_dot -= self.holding_rate(dynamics, configuration, g_dot);
        }
        if let Some((_, of_plane)) = self.contact_rate(dynamics, configuration, zeta_ddot) {
            Q_dot += of_plane;
        }
        for i in 0..DOF {
            let (w, a) = (zeta_dot[i], zeta_ddot[i]);
            Q_dot[i] -= (self.joint_viscous[i] + self.joint_dry.torque(i, w).1) * a;
            let stop = &self.stops[i];
            Q_dot[i] += if i < 3 {
                let Stroke { x, prime, second } = dynamics.strokes[i];
                let (x_dot, x_ddot) = (prime * w, prime * a + second * w * w);
                second * w * (input.f[i] + stop.force(x, x_dot))
                    + prime * stop.force_rate(x, x_dot, x_ddot)
            } else {
                stop.force_rate(zeta[i], w, a) + self.brake_rate(&dynamics.state, i - 3, a)
            };
        }
        dynamics.factor.solve(&Q_dot)
    }

    /// Rate of the torque by which a brake holds the joint of ideal wrist drive i, N·m/s, with the
    /// joint's acceleration `a`, rad/s².
    fn brake_rate(&self, state: &State, i: usize, a: f64) -> f64 {
        let drive = &state.wrist[i];
        if self.wrist.is_some() || !drive.holds {
            return 0.0;
        }
        let joint = [state.zeta[3 + i], state.zeta_dot[3 + i]];
        self.anchors[i].torque_rate(drive, joint, a)
    }
}
