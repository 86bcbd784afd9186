//! Result of one evaluation of the control law at one instant, from measurements to commands: the
//! FMU takes its outputs, `controller::step` advances the state with it, and `warnings` reads it.

use crate::bodies::HookModel;
use crate::drive::{Command, RodDemand};
use crate::law::BodyMotion;
use crate::measured::Plan;
use crate::reference::DesiredMotion;
use crate::signals::{Input, Output};
use crate::supervisor::{Plausibility, Stage, Supervisor};
use crate::tracking::Errors;
use hdrm::{Body, DOF, Stroke, saturate};
use nalgebra::Vector3;

/// Largest voltage that is passed on, V: what the drives' inputs take. A wrong speed asks for more.
const VOLTAGE_MAX: f64 = 1e4;

/// Result of one evaluation of the control law. The forces `F` enter the virtual power flows only.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evaluation {
    /// None at [`crate::Level::Actuator`].
    pub(crate) machine: Option<MachineLevel>,
    pub(crate) errors: Errors,
    pub(crate) demands: [RodDemand; 3],
    pub(crate) commands: [Command; 3],
    /// Required minus measured rod velocities, m/s.
    pub(crate) rate_error: [f64; 3],
    /// Held force measurements, N; None: measurements are not held.
    pub(crate) F: Option<[f64; 3]>,
    /// Whether the drives follow the required currents instead of the voltages.
    pub(crate) current_loop: bool,
    /// Contribution of the growing integral to the required accelerations of the rods, m/s²; used
    /// if a rod's force is limited.
    pub(crate) push: [f64; 3],
    /// Outputs without the virtual power flows.
    pub(crate) output: Output,
}

/// Quantities that exist at [`crate::Level::Machine`] only.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MachineLevel {
    pub(crate) desired: DesiredMotion,
    /// From the present to the desired orientation, rad.
    pub(crate) rotation_error: Vector3<f64>,
    /// Position of the tip, m.
    pub(crate) tip: Vector3<f64>,
    /// What is expected of the hook, while the payload is weighed.
    pub(crate) weighing: Option<HookModel>,
    /// Nominal inertias about the wrist joints, kg·m², if their friction is compensated, which it is on paths.
    pub(crate) wrist_inertia: Option<[f64; 3]>,
    /// Required joint rates, rad/s, and accelerations, rad/s².
    pub(crate) zeta_dot_r: [f64; DOF],
    pub(crate) zeta_ddot_r: [f64; DOF],
    pub(crate) strokes: [Stroke; 3],
    pub(crate) motions: [BodyMotion; Body::COUNT],
    /// Rate of the control law's integral.
    pub(crate) law_integral_rate: [f64; DOF],
    /// Σ ½ sᵀ M s with the nominal inertias, J.
    pub(crate) energy: f64,
    /// Power that the feedback of the rates takes out, W.
    pub(crate) dissipation: f64,
}

impl MachineLevel {
    /// Required joint rates minus the measured ones, rad/s.
    pub(crate) fn lacking(&self, zeta_dot: &[f64; DOF]) -> [f64; DOF] {
        std::array::from_fn(|j| self.zeta_dot_r[j] - zeta_dot[j])
    }
}

impl Evaluation {
    /// Outputs for the measured rod forces `F`, N.
    #[must_use]
    pub fn output(&self, F: &[f64; 3]) -> Output {
        let F = self.F.as_ref().unwrap_or(F);
        let flow = |i: usize| self.rate_error[i] * (self.demands[i].f_r - F[i]);
        Output {
            vpf: std::array::from_fn(flow),
            ..self.output
        }
    }

    /// An empty evaluation with the held measurements, if there are any.
    pub(crate) fn with_held(held: Option<&Input>) -> Self {
        Self {
            F: held.map(|held| held.F),
            ..Self::default()
        }
    }

    /// Sets the outputs that follow from demands and commands, and those of the tip, which are 0 at
    /// [`crate::Level::Actuator`].
    pub(crate) fn fill_outputs(&mut self, input: &Input) {
        let (demands, commands, output) = (&self.demands, &self.commands, &mut self.output);
        self.rate_error = std::array::from_fn(|i| demands[i].motion.x_r_dot - input.x_dot[i]);
        output.v_d = commands.map(|c| saturate(c.v_d, VOLTAGE_MAX));
        output.v_q = commands.map(|c| saturate(c.v_q, VOLTAGE_MAX));
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

    /// Whether voltage or current of a drive or torque of a wrist joint is at its limit.
    pub(crate) fn is_at_limit(&self, tau_wrist_max: &[f64; 3]) -> bool {
        let drive =
            |c: &Command| (!self.current_loop && c.voltage() >= c.v_max) || c.i_qr.abs() >= c.i_max;
        let mut wrist = self.output.tau_wrist.iter().zip(tau_wrist_max);
        self.commands.iter().any(drive) || wrist.any(|(tau, max)| tau.abs() >= *max)
    }

    /// Sets the outputs of the supervisor, and those for gates and brakes that follow from its
    /// stage; without supply the rods are off and braked, too.
    pub(crate) fn set_gates_and_brakes(&mut self, supervisor: &Supervisor, input: &Input) {
        let (stage, output) = (supervisor.stage(), &mut self.output);
        output.supervisor_state = stage as i32 + 1;
        output.supervisor_cause = supervisor.cause() as i32 + 1;
        let braked = stage >= Stage::Braking;
        let [a, b, c, wrist @ ..] = supervisor.gates();
        output.enable = [a, b, c].map(|on| on && !input.supply_missing);
        output.brake = [braked || input.supply_missing; 3];
        if let (Some(currents), true) = (supervisor.holding_currents(), self.current_loop) {
            output.i_q_required = currents;
        }
        (output.wrist_enable, output.wrist_brake) = (wrist, [braked; 3]);
    }

    /// Errors of force, N, and velocity, m/s, of each rod for the measured forces `F`, N.
    pub(crate) fn rod_errors(&self, F: &[f64; 3]) -> [[f64; 2]; 3] {
        let F = self.F.as_ref().unwrap_or(F);
        std::array::from_fn(|i| [self.demands[i].f_r - F[i], self.rate_error[i]])
    }

    /// Whether the payload is being weighed.
    pub(crate) fn weighs(&self) -> bool {
        let machine = self.machine.as_ref();
        machine.is_some_and(|machine| machine.weighing.is_some())
    }

    /// What measurements are compared with, where the reference `waits` for joints of boom or wrist, or
    /// does not; None at [`crate::Level::Actuator`].
    pub(crate) fn plausibility(&self, waits: [bool; 2]) -> Option<Plausibility> {
        let machine = self.machine.as_ref()?;
        Some(Plausibility {
            moves: machine.desired.is_moving(),
            waits,
            tip_error: self.output.tip_error,
            orientation_error: self.output.orientation_error_norm,
            primes: machine.strokes.map(|stroke| stroke.prime),
            zeta_dot_r: machine.zeta_dot_r,
            i_q_required: self.output.i_q_required,
        })
    }

    /// Voltages and accelerations of these commands, for the prediction.
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

    /// Whether the force of a rod is at its limit.
    pub(crate) fn is_at_force_limit(&self) -> bool {
        self.commands.iter().any(|c| c.at_force_limit != 0.0)
    }

    /// Whether the force of a rod is at its limit and the measured force `F`, N, exceeds its rating
    /// `[N, m/s]`. Below the rating it is not overload, but friction or velocity feedback.
    pub(crate) fn is_overloaded(&self, F: &[f64; 3], ratings: &[[f64; 2]; 3]) -> bool {
        let F = self.F.as_ref().unwrap_or(F);
        (0..3).any(|i| self.commands[i].at_force_limit != 0.0 && F[i].abs() > ratings[i][0])
    }

    /// Whether an increase in the direction `more` would exceed the force limit of rod `i`.
    pub(crate) fn pushes_beyond_limit(&self, i: usize, more: f64) -> bool {
        self.commands[i].at_force_limit * more > 0.0
    }
}
