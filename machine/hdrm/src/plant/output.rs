//! Outputs of the manipulator and their time derivatives at a state and input, for the FMU `Hdrm`.

use crate::dynamics::recursion;
use crate::plant::input::Input;
use crate::plant::state::State;
use crate::plant::{Dynamics, Hdrm};
use crate::{DOF, Stroke, Tip};
use nalgebra::{Quaternion, Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// Outputs of the plant, or their time derivatives or directional derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// Strokes of slew, lift and tilt, m.
    pub x: [f64; 3],
    /// Stroke rates, m/s.
    pub x_dot: [f64; 3],
    /// Joint angles, rad.
    pub zeta: [f64; DOF],
    /// Joint rates, rad/s.
    pub zeta_dot: [f64; DOF],
    /// Joint accelerations, rad/s²; these alone depend on the input.
    pub zeta_ddot: [f64; DOF],
    /// Rod forces that hold the present pose against gravity, N.
    pub f_hold: [f64; 3],
    /// Wrist torques that hold the present pose against gravity, N·m.
    pub tau_hold: [f64; 3],
    /// Tip position in the world, m.
    pub tip_position: [f64; 3],
    /// Tip orientation in the world, unit quaternion w, x, y, z.
    pub tip_orientation: [f64; 4],
    /// Tip velocity and angular velocity in world axes, m/s and rad/s.
    pub tip_velocity: [f64; 6],
    /// Kinetic energy of the motion relative to the base, J.
    pub energy_kinetic: f64,
    /// Potential energy, J, zero at the height of the world's origin.
    pub energy_potential: f64,
    /// Force of the plane on the tip in world axes, N.
    pub contact_force: [f64; 3],
    /// Depth of the tip below the plane, m; 0 above it.
    pub contact_penetration: f64,
    /// Elastic energy of the contact, J.
    pub energy_contact: f64,
    /// Energy dissipated by the contact, J.
    pub energy_contact_loss: f64,
    /// Energy added by changes of the load, J.
    pub energy_load: f64,
    /// Torques of the wrist's motors as built, N·m.
    pub wrist_torque: [f64; 3],
    /// Angles of these motors reflected to the joints, rad.
    pub wrist_angle: [f64; 3],
    /// Rates of these angles, rad/s.
    pub wrist_rate: [f64; 3],
}

impl Hdrm {
    /// Outputs at a state under an input.
    pub fn output(&self, state: &State, input: &Input) -> Output {
        self.output_at(&self.dynamics_with(state, input), input)
    }

    /// Outputs for known dynamics.
    pub fn output_at(&self, dynamics: &Dynamics, input: &Input) -> Output {
        let Dynamics {
            strokes, holding, ..
        } = dynamics;
        let State { zeta, zeta_dot, .. } = &dynamics.state;
        let touch = self.contact_force(dynamics);
        let (tip, V_tip) = dynamics.frame.tip_motion(zeta_dot);
        let (energy_kinetic, energy_potential) = self.energies_at(dynamics);
        Output {
            x: strokes.map(|stroke| stroke.x),
            x_dot: std::array::from_fn(|i| strokes[i].prime * zeta_dot[i]),
            zeta: *zeta,
            zeta_dot: *zeta_dot,
            zeta_ddot: self.acceleration(dynamics, input).into(),
            f_hold: std::array::from_fn(|i| holding[i] / strokes[i].prime),
            tau_hold: std::array::from_fn(|i| holding[3 + i]),
            tip_position: tip.into(),
            tip_orientation: components(&Tip::orientation(zeta)),
            tip_velocity: V_tip.to_vector().into(),
            energy_kinetic,
            energy_potential,
            contact_force: touch.force.into(),
            contact_penetration: touch.depth,
            energy_contact: touch.energy,
            energy_contact_loss: dynamics.state.contact_loss,
            energy_load: dynamics.state.load_energy,
            wrist_torque: dynamics.state.wrist.map(|drive| drive.motor),
            wrist_angle: dynamics.state.wrist.map(|drive| drive.angle),
            wrist_rate: dynamics.state.wrist.map(|drive| drive.rate),
        }
    }

    /// Exact time derivative of [`Hdrm::output`] while the input changes with `input_dot`.
    pub fn output_derivative(&self, state: &State, input: &Input, input_dot: &Input) -> Output {
        let State { zeta, zeta_dot, .. } = state;
        let dynamics = self.dynamics_with(state, input);
        let acceleration = self.acceleration(&dynamics, input);
        let zeta_ddot: [f64; DOF] = acceleration.into();
        let configuration = self.tree.configuration(zeta);
        let tip = Tip::new(&self.tree, &configuration);
        let w = Vector6::from(*zeta_dot);
        let J = tip.jacobian();
        let V_tip: Vector6<f64> = J * w;
        let strokes = &dynamics.strokes;

        let mut holding =
            recursion::gravity_forces(&configuration, &self.bodies, zeta_dot, &dynamics.gravity);
        let mut base_power = 0.0;
        if let Some(g_dot) = self.felt_gravity_rate(input, input_dot) {
            holding.rate += self.holding_rate(&dynamics, &configuration, g_dot);
            base_power = self.potential_rate(&configuration, g_dot);
        }
        let touch = self.contact_force(&dynamics);
        let contact_rate = self.contact_rate(&dynamics, &configuration, &zeta_ddot);
        let contact_power = touch.force.dot(&V_tip.fixed_rows::<3>(0));
        let depth_rate = self.depth_rate(&dynamics);
        // d/dt (Q/x′) = (Q_dot − (Q/x′) x″ zeta_dot)/x′
        let f_hold_rate = |i: usize| {
            let Stroke { prime, second, .. } = strokes[i];
            (holding.rate[i] - holding.value[i] / prime * second * zeta_dot[i]) / prime
        };
        let power_of_gravity = holding.value.dot(&w);
        let power: f64 = self.generalised_forces(&dynamics, input).dot(&w);
        let turning = self.turning_forces(state, input);
        let power_to_base = turning.map_or(0.0, |turning| turning.dot(&w));
        Output {
            x: std::array::from_fn(|i| strokes[i].prime * zeta_dot[i]),
            x_dot: std::array::from_fn(|i| {
                let Stroke { prime, second, .. } = strokes[i];
                second * zeta_dot[i] * zeta_dot[i] + prime * zeta_ddot[i]
            }),
            zeta: *zeta_dot,
            zeta_dot: zeta_ddot,
            zeta_ddot: self
                .acceleration_rate(&dynamics, &configuration, &zeta_ddot, input, input_dot)
                .into(),
            f_hold: std::array::from_fn(f_hold_rate),
            tau_hold: std::array::from_fn(|i| holding.rate[3 + i]),
            tip_position: [V_tip[0], V_tip[1], V_tip[2]],
            tip_orientation: components(&quaternion_rate(&Tip::orientation(zeta), &V_tip)),
            tip_velocity: (J * acceleration + tip.jacobian_dot(zeta_dot) * w).into(),
            energy_kinetic: power - power_of_gravity - power_to_base,
            energy_potential: power_of_gravity + base_power,
            contact_force: contact_rate.map_or([0.0; 3], |(rate, _)| rate.into()),
            contact_penetration: depth_rate,
            energy_contact: -contact_power - touch.dissipation,
            energy_contact_loss: touch.dissipation,
            ..Output::default()
        }
    }
}

/// w, x, y, z.
fn components(q: &Quaternion<f64>) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// `q_dot = ½ (0, w)·q` for the angular velocity w in world axes.
fn quaternion_rate(q: &Quaternion<f64>, V_tip: &Vector6<f64>) -> Quaternion<f64> {
    let w = Vector3::new(V_tip[3], V_tip[4], V_tip[5]);
    Quaternion::from_imag(w) * q * 0.5
}
