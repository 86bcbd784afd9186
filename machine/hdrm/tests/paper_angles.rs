//! The paper's own variables of lift and tilt, in which its formulas are printed.

use hdrm::{FourBar, Lift, Tilt};
use nalgebra::Vector2;

/// The paper's lift variables at one `zeta_2` (`[paper] Eq. (Eq:3_Bar_2)`, `(Eq:3_Bar_3)`), rad
/// and m. Angles by atan2, which equals the paper's arccos where that is defined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftAngles {
    /// `q_2 = zeta_2 − π/2 − beta1 − beta2`.
    pub q: f64,
    /// `q_1_2`, turn of the actuator against the line foot → O.
    pub q1: f64,
    /// `q_2_2 = q_2 − q_1_2`.
    pub q2: f64,
    /// `dq_1_2/dzeta_2`.
    pub q1_prime: f64,
    /// Actuator length `c_2 = x_2 + x0_2`, m.
    pub c: f64,
}

/// The paper's variables at `zeta_2`.
pub fn lift_angles(lift: &Lift, zeta_2: f64) -> LiftAngles {
    let e_A2 = unit(zeta_2 - lift.beta2);
    let actuator = lift.actuator(e_A2);
    // A2's x axis is at q_2 + π from the foot's direction; atan2 keeps q_2 in (−π, π].
    let q = angle_between(lift.foot, -e_A2);
    let q1 = angle_between(-lift.foot, actuator.e);
    LiftAngles {
        q,
        q1,
        q2: q - q1,
        q1_prime: actuator.angle_d[0],
        c: actuator.length,
    }
}

/// The paper's tilt variables at one `zeta_3` (`[paper] Eq. (Eq:4_Bar_1)` to `(Eq:4_Bar_6)`), rad
/// and m. Angles by atan2; `gamma_3` by arcsin as printed would fail past 90°.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltAngles {
    /// `q_3 = −gamma_7 − gamma_6 + zeta_3`: angle of the virtual line B → D against the line from
    /// E to B. The tilt boom itself turns with `zeta_3`, not with `q_3` as the paper has it.
    pub q: f64,
    /// `q_1_3`, turn of the actuator against the line E → B.
    pub q1: f64,
    /// `q_2_3 = q_3 − q_1_3`.
    pub q2: f64,
    /// `dq_3/dzeta_3`.
    pub q_prime: f64,
    /// `dq_1_3/dzeta_3`.
    pub q1_prime: f64,
    /// `L_1_3 = |BD|`, m.
    pub L1: f64,
    /// `L_2_3 = |BE|`, m.
    pub L2: f64,
    /// Actuator length `c_3 = x_3 + x0_3`, m.
    pub c: f64,
    /// Rate of the rocker relative to the LIFT boom A2 per `zeta_3` rate.
    pub phi_a_prime: f64,
    /// Rate of the coupler relative to the TILT boom A3 per `zeta_3` rate.
    pub phi_c_prime: f64,
}

/// The paper's variables at `zeta_3`.
pub fn tilt_angles(tilt: &Tilt, zeta_3: f64) -> TiltAngles {
    let loop_ = tilt.four_bar(unit(zeta_3));
    let FourBar { D, actuator, .. } = loop_;
    let q = angle_between(-tilt.E, D);
    let q1 = angle_between(-tilt.E, actuator.e);
    // D′ = d4 n_a a′, so the line BD turns by n_BD·D′/|BD|.
    let D1 = Vector2::new(-loop_.e_rocker.y, loop_.e_rocker.x) * (tilt.d4 * loop_.rocker_d[0]);
    TiltAngles {
        q,
        q1,
        q2: q - q1,
        q_prime: D.perp(&D1) / D.norm_squared(),
        q1_prime: actuator.angle_d[0],
        L1: D.norm(),
        L2: tilt.E.norm(),
        c: actuator.length,
        phi_a_prime: loop_.rocker_d[0],
        phi_c_prime: loop_.coupler_d[0] - 1.0,
    }
}

/// Paper constants `(gamma_1, gamma_7)`, rad: angle of B → A above, and of B → E below, the
/// boom's backward direction.
pub fn gamma(tilt: &Tilt) -> (f64, f64) {
    let above_back = |p: Vector2<f64>| p.y.atan2(-p.x);
    (above_back(tilt.A), -above_back(tilt.E))
}

/// Angle from `a` to `b`, counter-clockwise positive, rad, in (−π, π].
fn angle_between(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.perp(&b).atan2(a.dot(&b))
}

fn unit(psi: f64) -> Vector2<f64> {
    Vector2::new(psi.cos(), psi.sin())
}
