//! Closed-loop inverse kinematics, for `tracking`: required joint motion from the tip's error
//! ([Eq:Inverse Kinematics2]).

use crate::nominal::{Inverse, Singularities};
use crate::reference::DesiredMotion;
use crate::tracking::errors::Errors;
use crate::tracking::required::RequiredMotion;
use hdrm::{DOF, Tip};
use nalgebra::{UnitQuaternion, Vector3, Vector6};

/// Present state of the tip and the joints that move it.
pub(crate) struct TipState<'a> {
    pub(crate) tip: &'a Tip,
    pub(crate) singularities: &'a Singularities,
    pub(crate) orientation: UnitQuaternion<f64>,
    pub(crate) zeta: &'a [f64; DOF],
    pub(crate) zeta_dot: &'a [f64; DOF],
}

/// Desired minus actual pose of the tip: position m, orientation rad.
pub(crate) fn pose_error(now: &TipState, desired: &DesiredMotion) -> Vector6<f64> {
    stacked(
        desired.position - now.tip.position,
        rotation_error(&desired.orientation, &now.orientation),
    )
}

/// Required joint motion to follow `desired`, from the tip's error `e = Π_d − Π`, its integral z
/// and its rate z'; `seen` is the reference at the time of the measurements.
/// ```text
/// ζ̇_r = J⁻¹ (Π̇_d + Λ (e + z))
/// ζ̈_r = J⁻¹ (Π̈_d + Λ (Π̇_d − Π̇ + z') − J̇ ζ̇_r)
/// ```
/// The second line is the derivative of the first, exact in position and to first order in the
/// orientation error. Near the singularities of wrist and elbow the inverse is damped. The paper's
/// law has z = 0.
pub(crate) fn required(
    now: &TipState,
    desired: &DesiredMotion,
    seen: &DesiredMotion,
    Errors { e, z, z_dot }: &Errors,
    [Lambda_position, Lambda_orientation]: [f64; 2],
) -> RequiredMotion {
    let J = now.tip.jacobian();
    let J_dot = now.tip.jacobian_dot(now.zeta_dot);
    let [p, o] = [Lambda_position, Lambda_orientation];
    let Lambda = Vector6::new(p, p, p, o, o, o);
    let Pi_dot = J * Vector6::from(*now.zeta_dot);
    let Pi_dot_d = stacked(desired.velocity, desired.angular_velocity);
    let e_dot = stacked(seen.velocity, seen.angular_velocity) - Pi_dot;

    let inverse = Inverse::new(J, now.singularities, now.zeta);
    let zeta_dot = inverse.apply(Pi_dot_d + Lambda.component_mul(&(e + z)));
    let Pi_ddot_r =
        stacked(desired.acceleration, Vector3::zeros()) + Lambda.component_mul(&(e_dot + z_dot));
    let zeta_ddot = inverse.apply(Pi_ddot_r - J_dot * zeta_dot);
    RequiredMotion {
        zeta_dot,
        zeta_ddot,
    }
}

pub(crate) fn stacked(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

/// Joint rates, rad/s, that move the tip with `twist`, m/s and rad/s.
pub(crate) fn joint_rates(
    tip: &Tip,
    singularities: &Singularities,
    zeta: &[f64; DOF],
    twist: Vector6<f64>,
) -> Vector6<f64> {
    Inverse::new(tip.jacobian(), singularities, zeta).apply(twist)
}

/// World-frame rotation from the present to the desired orientation, rad for small errors:
/// `2·sign(w)·vec(q_d·q⁻¹)`.
pub(crate) fn rotation_error(
    desired: &UnitQuaternion<f64>,
    now: &UnitQuaternion<f64>,
) -> Vector3<f64> {
    let q = desired * now.inverse();
    q.imag() * (2.0 * q.w.signum())
}
