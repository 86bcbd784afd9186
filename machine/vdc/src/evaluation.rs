//! What one evaluation of the control law finds: all between the measurements and the commands at
//! one instant.

use crate::bodies::WristInertia;
use crate::drive::{Command, RodDemand};
use crate::law::BodyMotion;
use crate::measured::Plan;
use crate::reference::DesiredMotion;
use crate::signals::{Input, Output};
use crate::supervisor::Stage;
use crate::tracking::Errors;
use hdrm::{Body, DOF, Stroke};
use nalgebra::Vector3;

/// Everything between the measurements and the commands at one instant. The forces `F` count in the
/// virtual power flows only.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evaluation {
    /// None at [`crate::Level::Actuator`].
    pub(crate) machine: Option<MachineLevel>,
    pub(crate) errors: Errors,
    pub(crate) demands: [RodDemand; 3],
    pub(crate) commands: [Command; 3],
    /// Required minus measured rod velocities, m/s.
    pub(crate) rate_error: [f64; 3],
    /// Forces where measurements are held, N.
    pub(crate) F: Option<[f64; 3]>,
    /// Whether the drives follow the required currents instead of the voltages.
    pub(crate) current_loop: bool,
    /// What the growth of the integral adds to the required accelerations of the rods, m/s²; read
    /// where a rod's force is limited.
    pub(crate) push: [f64; 3],
    /// Without the virtual power flows.
    pub(crate) output: Output,
}

/// What only the level of the machine has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MachineLevel {
    pub(crate) desired: DesiredMotion,
    /// From the present to the desired orientation, rad.
    pub(crate) rotation_error: Vector3<f64>,
    /// Position of the tip, m.
    pub(crate) tip: Vector3<f64>,
    /// Inertia at the wrist, while the payload is weighed.
    pub(crate) weighing: Option<WristInertia>,
    /// Required joint accelerations, rad/s².
    pub(crate) zeta_ddot_r: [f64; DOF],
    pub(crate) strokes: [Stroke; 3],
    pub(crate) motions: [BodyMotion; Body::COUNT],
    /// Rate of what the law integrates.
    pub(crate) law_integral_rate: [f64; DOF],
    /// Σ ½ sᵀ M s with the nominal inertias, J.
    pub(crate) energy: f64,
}

impl Evaluation {
    /// Outputs where the actuators deliver the forces `F`, N.
    #[must_use]
    pub fn output(&self, F: &[f64; 3]) -> Output {
        let F = self.F.as_ref().unwrap_or(F);
        let flow = |i: usize| self.rate_error[i] * (self.demands[i].f_r - F[i]);
        Output {
            vpf: std::array::from_fn(flow),
            ..self.output
        }
    }

    /// Nothing yet, with the measurements `held`, where these are not those of the moment.
    pub(crate) fn with_held(held: Option<&Input>) -> Self {
        Self {
            F: held.map(|held| held.F),
            ..Self::default()
        }
    }

    /// Fills the outputs of demands and commands, and those of the tip; at
    /// [`crate::Level::Actuator`] these stay 0.
    pub(crate) fn fill_outputs(&mut self, input: &Input) {
        let (demands, commands, output) = (&self.demands, &self.commands, &mut self.output);
        self.rate_error = std::array::from_fn(|i| demands[i].motion.x_r_dot - input.x_dot[i]);
        output.v_d = commands.map(|c| c.v_d);
        output.v_q = commands.map(|c| c.v_q);
        output.i_q_required = commands.map(|c| c.i_qr);
        output.f_required = demands.map(|d| d.f_r);
        output.x_dot_required = demands.map(|d| d.motion.x_r_dot);
        let Some(machine) = &self.machine else { return };
        let tip_error = machine.desired.position - machine.tip;
        output.desired_position = machine.desired.position.into();
        output.tip_error = tip_error.into();
        output.tip_error_norm = tip_error.norm();
        let q = machine.desired.orientation;
        output.desired_orientation = [q.w, q.i, q.j, q.k];
        let half_sine = 0.5 * machine.rotation_error.norm();
        output.orientation_error_norm = 2.0 * libm::asin(half_sine.min(1.0));
    }

    /// Whether a command is at a limit: voltage or current of a drive, torque of a wrist joint,
    /// N·m.
    pub(crate) fn is_at_limit(&self, tau_wrist_max: &[f64; 3]) -> bool {
        let drive =
            |c: &Command| (!self.current_loop && c.voltage() >= c.v_max) || c.i_qr.abs() >= c.i_max;
        let mut wrist = self.output.tau_wrist.iter().zip(tau_wrist_max);
        self.commands.iter().any(drive) || wrist.any(|(tau, max)| tau.abs() >= *max)
    }

    /// What the stage of the supervisor asks of gates and brakes.
    pub(crate) fn set_gates_and_brakes(&mut self, stage: Stage) {
        self.output.supervisor_state = stage as i32 + 1;
        self.output.enable = [stage != Stage::Stopped; 3];
        self.output.brake = [stage >= Stage::Braking; 3];
    }

    /// Errors of force, N, and velocity, m/s, of each rod, where the forces `F`, N, are measured.
    pub(crate) fn rod_errors(&self, F: &[f64; 3]) -> [[f64; 2]; 3] {
        let F = self.F.as_ref().unwrap_or(F);
        std::array::from_fn(|i| [self.demands[i].f_r - F[i], self.rate_error[i]])
    }

    /// What acts with these commands.
    pub(crate) fn plan(&self) -> Plan {
        let machine = self.machine.as_ref();
        Plan {
            v_d: self.output.v_d,
            v_q: self.output.v_q,
            zeta_ddot: machine.map_or([0.0; DOF], |m| m.zeta_ddot_r),
            x_ddot: self.demands.map(|d| d.motion.x_r_ddot),
            strokes: machine.map(|m| m.strokes.map(|Stroke { x, prime, .. }| [x, prime])),
        }
    }

    /// Whether a rod has the largest force that it may be asked for.
    pub(crate) fn is_at_force_limit(&self) -> bool {
        self.commands.iter().any(|c| c.at_force_limit != 0.0)
    }

    /// Whether a rod has the largest force that it may be asked for, and more than its rated one
    /// is measured: `F`, N, where rods are rated `[N, m/s]`. Less is no load beyond the machine,
    /// but a current that friction or the velocity feedback takes.
    pub(crate) fn is_overloaded(&self, F: &[f64; 3], ratings: &[[f64; 2]; 3]) -> bool {
        let F = self.F.as_ref().unwrap_or(F);
        (0..3).any(|i| self.commands[i].at_force_limit != 0.0 && F[i].abs() > ratings[i][0])
    }

    /// Whether `more[i]` asks rod `i` for more force where it has the largest already.
    pub(crate) fn pushes_beyond_limit(&self, i: usize, more: f64) -> bool {
        self.commands[i].at_force_limit * more > 0.0
    }
}
