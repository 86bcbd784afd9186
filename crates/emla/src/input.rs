//! Inputs, and their course inside a step.

use serde::{Deserialize, Serialize};

/// What acts on the actuator at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Direct-axis voltage v_d, V (peak).
    pub v_d: f64,
    /// Quadrature-axis voltage v_q, V (peak).
    pub v_q: f64,
    /// Rod position x, m, positive when extended. In [`crate::Drive::Force`] read at the start only.
    pub x: f64,
    /// Rod velocity, m/s. In [`crate::Drive::Force`] read at the start only.
    pub x_dot: f64,
    /// External force on the rod, N, positive against extension. [`crate::Drive::Force`] only.
    pub F_ext: f64,
    /// Force that the actuator delivers at the start, N, positive when it pushes. Read at the start only.
    pub F_hold: f64,
}

/// Inputs as Taylor polynomials about the start of a step.
///
/// The rod's position is never held: it follows from its velocity and that velocity's derivatives,
/// `x(t) = x + x_dot·t + ½·x_ddot·t² + …`. Holding x while x_dot ≠ 0 would cost K_b·x_dot·h of force,
/// some 20 kN at 1 ms. Derivatives of `x` itself are therefore not read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InputPath {
    /// Values at the start of the step.
    pub u: Input,
    /// First, second and third time derivatives there.
    pub derivatives: [Input; 3],
}

impl InputPath {
    /// Held voltages and forces; the rod moves at constant velocity.
    #[must_use]
    pub fn held(u: Input) -> Self {
        Self {
            u,
            ..Self::default()
        }
    }

    /// The inputs a time `t` after the start of the step, s.
    #[must_use]
    pub fn at(&self, t: f64) -> Input {
        let Self {
            u,
            derivatives: [d1, d2, d3],
        } = self;
        let (t2, t3) = (t * t / 2.0, t * t * t / 6.0);
        let taylor = |get: fn(&Input) -> f64| get(u) + t * get(d1) + t2 * get(d2) + t3 * get(d3);
        let t4 = t2 * t2 / 6.0;
        Input {
            v_d: taylor(|u| u.v_d),
            v_q: taylor(|u| u.v_q),
            x: u.x + t * u.x_dot + t2 * d1.x_dot + t3 * d2.x_dot + t4 * d3.x_dot,
            x_dot: taylor(|u| u.x_dot),
            F_ext: taylor(|u| u.F_ext),
            F_hold: u.F_hold,
        }
    }
}
