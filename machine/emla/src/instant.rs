//! The algebraic part of the model: spring force, friction, transmission and motor torque at one
//! instant, from which `dynamics`, `losses`, `output` and `tangent` compute rates and outputs.

use crate::actuator::Emla;
use crate::conditions::Conditions;
use crate::state::Point;
use crate::{maps, motor};
use machine_file::{ActuatorInput as Input, BrakeState, Dq, Drive};

/// Quantities that follow from state and inputs at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instant {
    /// Voltage after limitation, V.
    pub v: Dq,
    /// Current, A.
    pub i: Dq,
    /// Flux linkage, Wb.
    pub lambda: Dq,
    /// Electrical speed, rad/s.
    pub w_e: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Electromagnetic torque, N·m.
    pub tau_e: f64,
    /// Rod position, m.
    pub x: f64,
    /// Rod velocity, m/s.
    pub x_dot: f64,
    /// Nut velocity, m/s.
    pub x_n_dot: f64,
    /// Stiffness between nut and rod, N/m.
    pub K_b: f64,
    /// Its derivative by x, N/m².
    pub K_b_slope: f64,
    /// `x_n − x`, m.
    pub stretch: f64,
    /// `x_n_dot − x_dot`, m/s.
    pub stretch_dot: f64,
    /// Force on the load, N.
    pub F: f64,
    /// Friction of the motor, N·m.
    pub tau_friction: f64,
    /// Torque of friction and nut on the screw, N·m.
    pub tau_load: f64,
    /// Gear factor.
    pub k: f64,
    /// Accelerating torque, as if a holding brake were released, N·m.
    pub torque_left: f64,
    /// Motor acceleration, rad/s².
    pub w_m_dot: f64,
}

impl Emla {
    /// Source: `[paper]` Eq. (eq:backdrive_torque) for the spring; Eq. (eq:rotor_dynamics), Eq.
    /// (eq:gear_torque) and Eq. (eq:screw_dynamics) merged into one equation, because a rigid gear
    /// has one degree of freedom:
    /// ```text
    /// F_spring = C_b (ẋ_n − ẋ) + K_b(x)·(x_n − x),   F = F_spring − C_act ẋ,   F_nut = F_spring − α·dF
    /// (J_m + k J_s/N²) ẇ_m = τ_e − C_m w_m − τ_C tanh(w_m/w_C) − k (C_s w_m/N + lead·F_nut)/N
    /// ```
    #[inline(always)] // so that parameter-only expressions move out of the substep loops
    pub(crate) fn instant(&self, s: &Point, u: &Input, held: &Conditions) -> Instant {
        let p = held.p;
        let (x, x_dot) = match held.drive {
            Drive::Motion => (u.x, u.x_dot),
            Drive::Force => (s.x, s.x_dot),
        };
        let (i, w_m) = (s.current(), s.w_m);
        let travel = maps::travel_per_radian(p);
        let x_n_dot = travel * w_m;
        let (stretch, stretch_dot) = (travel * s.theta_m - x, x_n_dot - x_dot);
        let (K_b, K_b_slope) = maps::stiffness_and_slope(p, x);
        let F_spring = p.C_b * stretch_dot + K_b * stretch;
        let F_nut = F_spring - held.residual;
        let tau_load = maps::screw_load(p, F_nut, w_m);
        let k = maps::gear_factor(p, tau_load, w_m);
        let tau_e = maps::torque(p, i.d, i.q);
        let tau_friction = maps::motor_friction(p, w_m);
        let mut torque_left = tau_e - tau_friction - 1.0 / p.N_gear * (k * tau_load);
        let mut v = u.voltage().limited(held.largest);
        let mut w_m_dot = torque_left / maps::inertia(p, k);
        if !held.is_plain() {
            torque_left -= held.brake.torque();
            w_m_dot = match held.brake {
                BrakeState::Holds => 0.0,
                _ => torque_left / maps::inertia(p, k),
            };
            if !held.gates {
                v = Dq::default();
            }
        }
        Instant {
            v,
            i,
            lambda: motor::flux(p, i),
            w_e: f64::from(p.p) * w_m,
            w_m,
            tau_e,
            x,
            x_dot,
            x_n_dot,
            K_b,
            K_b_slope,
            stretch,
            stretch_dot,
            F: F_spring - p.C_act * x_dot,
            tau_friction,
            tau_load,
            k,
            torque_left,
            w_m_dot,
        }
    }
}
