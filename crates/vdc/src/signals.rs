//! What goes into the controller and what comes out.

use crate::{Conditions, Load, RateCommand};
use hdrm::{Body, DOF};
use machine::Controller as Gains;
use serde::{Deserialize, Serialize};

/// How much of the controller is at work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// Model-based with natural adaptation (the paper's proposal).
    Adaptive,
    /// Model-based with the nominal parameters.
    Modular,
    /// Neither model nor adaptation: inverse kinematics, damping and decoupling only.
    Pd,
    /// As `Pd`, with the forces that hold the nominal machine against gravity.
    PdGravity,
}

/// What the controller follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Level {
    /// The tip's reference, through inverse kinematics and decomposition, down to the voltages.
    Machine,
    /// References of the rods alone: each actuator by itself, as on a one-axis testbed.
    Actuator,
}

/// What may be changed while the controller runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Which parts are at work.
    pub mode: Mode,
    /// Whether the integral of the tip's error acts (at [`Level::Actuator`] of the rods' errors), at the rate `gains.omega_tip`.
    pub integral: bool,
    /// What is followed; not to be changed while the controller runs.
    pub level: Level,
    /// Gains.
    pub gains: Gains,
    /// Blending factor α of the hybrid actuator that the low-level law reckons with, 0…1; 0: it
    /// knows the physics only.
    pub alpha: f64,
    /// Inertia of the plant over nominal, for the Lyapunov outputs only.
    pub true_inertia_scale: f64,
    /// Less current for hot windings; None: `i_max` at any temperature.
    pub derating: Option<Derating>,
    /// What the commanded rates are of, if the trajectory is [`crate::Trajectory::Rates`].
    pub rate_command: RateCommand,
    /// Whether the controller is told of the loads that a path picks up and sets down.
    pub load_told: bool,
}

impl Settings {
    /// The adaptive controller of the whole machine with these gains, which reckons with the physics alone and is told of loads; no integral,
    /// no derating.
    #[must_use]
    pub fn of(gains: &Gains) -> Self {
        Self {
            mode: Mode::Adaptive,
            integral: false,
            level: Level::Machine,
            gains: *gains,
            alpha: 0.0,
            true_inertia_scale: 1.0,
            derating: None,
            rate_command: RateCommand::Joint,
            load_told: true,
        }
    }
}

/// Currents fall with the winding's temperature: up to `start` the law asks for up to `i_max`, from `end` on for nothing, in between for a share
/// that falls linearly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Derating {
    /// Temperature from which on the current is reduced, K.
    pub start: f64,
    /// Temperature from which on there is none, K.
    pub end: f64,
}

impl Derating {
    /// Share of `i_max` at the winding temperature `T`, K.
    pub(crate) fn share(&self, T: f64) -> f64 {
        ((self.end - T) / (self.end - self.start)).clamp(0.0, 1.0)
    }
}

/// Measurements and the external reference.
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
    /// Rod positions, m; read at [`Level::Actuator`].
    pub x: [f64; 3],
    /// Rod velocities, m/s; read at [`Level::Actuator`] and by the virtual power flows.
    pub x_dot: [f64; 3],
    /// Actuator forces, N; read by the virtual power flows and, in a step, by the disturbance observer.
    pub F: [f64; 3],
    /// Voltage of the DC link, V; None: the nominal machine's.
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
    /// Rod references of [`Level::Actuator`]: positions, m.
    pub reference_rod_position: [f64; 3],
    /// Rod references: velocities, m/s.
    pub reference_rod_velocity: [f64; 3],
    /// Rod references: accelerations, m/s².
    pub reference_rod_acceleration: [f64; 3],
    /// Rod references: forces on the load, N.
    pub reference_rod_force: [f64; 3],
    /// What it is told of the base: its tilt, rad (roll about x, then pitch about its own z).
    pub base_tilt: [f64; 2],
    /// Its acceleration in the machine's world axes, m/s².
    pub base_acceleration: [f64; 3],
    /// Its angular velocity in those axes, rad/s.
    pub base_angular_velocity: [f64; 3],
    /// The rate of that, rad/s².
    pub base_angular_acceleration: [f64; 3],
    /// Commanded joint rates, rad/s.
    pub rate_joint: [f64; DOF],
    /// Commanded velocity (m/s) and angular velocity (rad/s) of the tip in the world.
    pub rate_tip: [f64; DOF],
}

/// Commands and what led to them.
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
    /// Time at which the reference has come to its end, s; the start time for an external one.
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
    /// What the path has the end-effector carry.
    pub load: Load,
}
