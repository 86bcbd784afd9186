//! Inputs and outputs of the controller, which the FMU sets and reads.

use crate::conditions::Conditions;
use hdrm::{Body, DOF};
use serde::{Deserialize, Serialize};
use tip_path::Load;

/// Inputs: measurements, the external reference, and commands of an operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Joint angles, rad.
    pub zeta: [f64; DOF],
    /// Joint rates, rad/s.
    pub zeta_dot: [f64; DOF],
    /// Direct-axis currents, A.
    pub i_d: [f64; 3],
    /// Quadrature-axis currents, A.
    pub i_q: [f64; 3],
    /// Motor speeds, rad/s.
    pub w_m: [f64; 3],
    /// Rod positions, m; read at [`crate::Level::Actuator`].
    pub x: [f64; 3],
    /// Rod velocities, m/s; read at [`crate::Level::Actuator`] and by the virtual power flows.
    pub x_dot: [f64; 3],
    /// Actuator forces, N; read by the virtual power flows and, in a step, by the disturbance
    /// observer.
    pub F: [f64; 3],
    /// Voltage of the DC link, V; None: that of the nominal machine.
    pub v_dc: Option<f64>,
    /// Temperatures of the windings, K; read by the derating.
    pub T_winding: [f64; 3],
    /// External reference: tip position in the world, m.
    pub reference_position: [f64; 3],
    /// External reference: tip velocity, m/s.
    pub reference_velocity: [f64; 3],
    /// External reference: tip acceleration, m/s².
    pub reference_acceleration: [f64; 3],
    /// External reference: tip orientation, quaternion w, x, y, z (normalised when read).
    pub reference_orientation: [f64; 4],
    /// External reference: tip angular velocity in the world, rad/s.
    pub reference_angular_velocity: [f64; 3],
    /// Rod references of [`crate::Level::Actuator`]: positions, m.
    pub reference_rod_position: [f64; 3],
    /// Rod references: velocities, m/s.
    pub reference_rod_velocity: [f64; 3],
    /// Rod references: accelerations, m/s².
    pub reference_rod_acceleration: [f64; 3],
    /// Rod references: forces on the load, N.
    pub reference_rod_force: [f64; 3],
    /// Measured tilt of the base, rad (roll about x, then pitch about its own z).
    pub base_tilt: [f64; 2],
    /// Measured acceleration of the base in the machine's world axes, m/s².
    pub base_acceleration: [f64; 3],
    /// Measured angular velocity of the base in those axes, rad/s.
    pub base_angular_velocity: [f64; 3],
    /// Measured angular acceleration of the base in those axes, rad/s².
    pub base_angular_acceleration: [f64; 3],
    /// Commanded joint rates, rad/s.
    pub rate_joint: [f64; DOF],
    /// Commanded velocity (m/s) and angular velocity (rad/s) of the tip in the world.
    pub rate_tip: [f64; DOF],
    /// Whether a drive has tripped.
    pub tripped: [bool; 3],
    /// Motor angles, rad; None: not known.
    pub theta_m: Option<[f64; 3]>,
    /// A rising edge makes a stopped machine ready again.
    pub reset: bool,
    /// Whether the drives' supply is not ready: gates off, brakes applied.
    pub supply_missing: bool,
}

/// Outputs: commands, and quantities that led to them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Direct-axis voltages, V.
    pub v_d: [f64; 3],
    /// Quadrature-axis voltages, V.
    pub v_q: [f64; 3],
    /// Wrist torques, N·m, saturated at their limits.
    pub tau_wrist: [f64; 3],
    /// Required actuator forces, N.
    pub f_required: [f64; 3],
    /// Required rod velocities, m/s.
    pub x_dot_required: [f64; 3],
    /// Required quadrature-axis currents, A.
    pub i_q_required: [f64; 3],
    /// Time at which the reference ends, s; the start time for an external one.
    pub motion_end: f64,
    /// Desired tip position, m.
    pub desired_position: [f64; 3],
    /// Desired tip orientation, quaternion w, x, y, z.
    pub desired_orientation: [f64; 4],
    /// Desired minus actual tip position, m.
    pub tip_error: [f64; 3],
    /// Length of the tip error, m.
    pub tip_error_norm: f64,
    /// Angle between the desired and the actual tip orientation, rad.
    pub orientation_error_norm: f64,
    /// Estimated body masses, kg, in the order of [`hdrm::BODIES`].
    pub mass_hat: [f64; Body::COUNT],
    /// Σ ½ sᵀ M s with the plant's inertias (nominal times `true_inertia_scale`), W·s.
    pub nu_velocity: f64,
    /// Σ γ D_F(L‖L̂).
    pub nu_adaptation: f64,
    /// ν_a of each actuator.
    pub nu_actuator: [f64; 3],
    /// Σ sᵀ K_A s, the dissipation of Theorem 2, W.
    pub dissipation: f64,
    /// Dissipation of each actuator in the bound on ν̇_a (eq:dv_EMLA3), W.
    pub dissipation_actuator: [f64; 3],
    /// `F_hyb,r − F_hyb` of each actuator by eq:Error_Force_EMLA, from the currents, N.
    pub force_error: [f64; 3],
    /// Stability conditions of the low-level law; all 0 where they fail.
    pub conditions: Conditions,
    /// Virtual power flow (ẋ_r − ẋ)(f_r − F) into the manipulator at each rod, W.
    pub vpf: [f64; 3],
    /// Load of the path.
    pub load: Load,
    /// Stage of the supervisor: number of the [`crate::Stage`], from 1.
    pub supervisor_state: i32,
    /// Command for the drives' gates: whether they are on.
    pub enable: [bool; 3],
    /// Command for the holding brakes: whether they are applied.
    pub brake: [bool; 3],
    /// Why the supervisor acts: number of the [`crate::Cause`], from 1.
    pub supervisor_cause: i32,
    /// Command for the wrist's drives: whether they give torque.
    pub wrist_enable: [bool; 3],
    /// Command for the wrist's brakes: whether they are applied.
    pub wrist_brake: [bool; 3],
    /// Lap of the path that is under way, from 1; 0: none.
    pub lap: i32,
    /// Shift of the tip's position that was learnt on the laps before, m.
    pub learnt_shift: [f64; 3],
}

impl Output {
    /// Name and value of the first signal that is not finite.
    pub(crate) fn not_finite(&self) -> Option<(&'static str, f64)> {
        let scalar = std::slice::from_ref;
        let signals: [(&'static str, &[f64]); 11] = [
            ("v_d", &self.v_d),
            ("v_q", &self.v_q),
            ("tau_wrist", &self.tau_wrist),
            ("f_required", &self.f_required),
            ("x_dot_required", &self.x_dot_required),
            ("nu_velocity", scalar(&self.nu_velocity)),
            ("nu_adaptation", scalar(&self.nu_adaptation)),
            ("nu_actuator", &self.nu_actuator),
            ("dissipation", scalar(&self.dissipation)),
            ("dissipation_actuator", &self.dissipation_actuator),
            ("force_error", &self.force_error),
        ];
        signals.into_iter().find_map(|(signal, values)| {
            let value = values.iter().find(|v| !v.is_finite())?;
            Some((signal, *value))
        })
    }
}
