//! Closed-loop inverse kinematics: required joint motion from the tip's error
//! ([Eq:Inverse Kinematics2]).

use crate::integral::Errors;
use crate::reference::Desired;
use hdrm::{DOF, Tip};
use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};

/// |sin zeta_5| below which the inverse is damped: there the first and third wrist axes align.
const NEAR_SINGULAR: f64 = 0.05;
/// Damping at the singularity itself, in the Jacobian's mixed units (m and rad).
const DAMPING: f64 = 0.03;

/// Required joint rates and accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Required {
    /// `zeta_dot_r`, rad/s.
    pub(crate) zeta_dot: Vector6<f64>,
    /// `zeta_ddot_r`, rad/s².
    pub(crate) zeta_ddot: Vector6<f64>,
}

/// Present state of the tip and the joints that move it.
pub(crate) struct TipState<'a> {
    pub(crate) tip: &'a Tip,
    pub(crate) orientation: UnitQuaternion<f64>,
    pub(crate) zeta: &'a [f64; DOF],
    pub(crate) zeta_dot: &'a [f64; DOF],
}

/// Desired minus actual pose of the tip: position m, orientation rad.
pub(crate) fn pose_error(now: &TipState, desired: &Desired) -> Vector6<f64> {
    stacked(
        desired.position - now.tip.position,
        rotation_error(&desired.orientation, &now.orientation),
    )
}

/// Required joint motion towards `desired`, where the measurements belong to the reference `seen`, from the tip's error `e = Π_d − Π`,
/// its integral part z and its rate z'.
/// ```text
/// ζ̇_r = J⁻¹ (Π̇_d + Λ (e + z))
/// ζ̈_r = J⁻¹ (Π̈_d + Λ (Π̇_d − Π̇ + z') − J̇ ζ̇_r)
/// ```
/// The second line is the derivative of the first, exact in position and to first order in the
/// orientation error. Near the wrist singularity the inverse is damped. The paper's law has z = 0.
pub(crate) fn required(
    now: &TipState,
    desired: &Desired,
    seen: &Desired,
    Errors { e, z, z_dot }: &Errors,
    [Lambda_position, Lambda_orientation]: [f64; 2],
) -> Required {
    let J = now.tip.jacobian();
    let J_dot = now.tip.jacobian_dot(now.zeta_dot);
    let [p, o] = [Lambda_position, Lambda_orientation];
    let Lambda = Vector6::new(p, p, p, o, o, o);
    let Pi_dot = J * Vector6::from(*now.zeta_dot);
    let Pi_dot_d = stacked(desired.velocity, desired.angular_velocity);
    let e_dot = stacked(seen.velocity, seen.angular_velocity) - Pi_dot;

    let inverse = Inverse::of(J, libm::sin(now.zeta[4]));
    let zeta_dot = inverse.apply(Pi_dot_d + Lambda.component_mul(&(e + z)));
    let Pi_ddot_r =
        stacked(desired.acceleration, Vector3::zeros()) + Lambda.component_mul(&(e_dot + z_dot));
    let zeta_ddot = inverse.apply(Pi_ddot_r - J_dot * zeta_dot);
    Required {
        zeta_dot,
        zeta_ddot,
    }
}

fn stacked(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

/// World-frame rotation from the present to the desired orientation, rad for small errors:
/// `2·sign(w)·vec(q_d·q⁻¹)`.
fn rotation_error(desired: &UnitQuaternion<f64>, now: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = desired * now.inverse();
    q.imag() * (2.0 * q.w.signum())
}

/// `J⁻¹`, or `Jᵀ(J·Jᵀ + μ²)⁻¹` near the wrist singularity; μ grows smoothly from zero.
struct Inverse {
    lu: nalgebra::LU<f64, nalgebra::U6, nalgebra::U6>,
    /// Jᵀ where the inverse is damped.
    transposed: Option<Matrix6<f64>>,
}

impl Inverse {
    fn of(J: Matrix6<f64>, sin_zeta_5: f64) -> Self {
        let near = 1.0 - (sin_zeta_5 / NEAR_SINGULAR).powi(2);
        if near <= 0.0 {
            return Self {
                lu: J.lu(),
                transposed: None,
            };
        }
        let damped = J * J.transpose() + Matrix6::from_diagonal_element(DAMPING * DAMPING * near);
        Self {
            lu: damped.lu(),
            transposed: Some(J.transpose()),
        }
    }

    fn apply(&self, b: Vector6<f64>) -> Vector6<f64> {
        // A singular arm (stretched elbow) is outside the joint limits; nothing moves there.
        let x = self.lu.solve(&b).unwrap_or_else(Vector6::zeros);
        match &self.transposed {
            None => x,
            Some(J_transposed) => J_transposed * x,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdrm::Tree;
    use machine::Machine;

    fn jacobian(zeta_5: f64) -> Matrix6<f64> {
        let machine = Machine::reference();
        let tree = Tree::new(&machine).expect("works");
        let mut zeta = machine.start.zeta;
        zeta[4] = zeta_5;
        Tip::new(&tree, &tree.configuration(&zeta)).jacobian()
    }

    /// Near zeta_5 = 0 the solution minimises |J·x − b|² + μ²|x|², so its gradient is zero, and |x| ≤ |b|/(2μ) however
    /// singular J is. Tolerance: condition of J·Jᵀ + μ², some 1e5, times 36 rounded products.
    #[test]
    fn near_the_wrist_singularity_the_inverse_is_damped() {
        let b = Vector6::new(0.3, -0.2, 0.1, 0.5, -0.7, 0.4);
        for zeta_5 in [-0.04, -1e-9, 0.0, 1e-9, 0.02] {
            let (J, sine) = (jacobian(zeta_5), f64::sin(zeta_5));
            let x = Inverse::of(J, sine).apply(b);
            let mu2 = DAMPING * DAMPING * (1.0 - (sine / NEAR_SINGULAR).powi(2));
            let gradient = J.transpose() * (J * x - b) + x * mu2;
            assert!(gradient.norm() < 1e-9, "zeta_5 = {zeta_5}: {gradient}");
            assert!(
                x.norm() <= b.norm() / (2.0 * mu2.sqrt()),
                "zeta_5 = {zeta_5}: {x}"
            );
            assert!(x.norm() > 0.1, "zeta_5 = {zeta_5}: {x}");
        }
    }

    /// Where the damping begins the inverse is exact, and there is no jump.
    #[test]
    fn elsewhere_the_inverse_is_exact() {
        let b = Vector6::new(0.3, -0.2, 0.1, 0.5, -0.7, 0.4);
        let at_edge = NEAR_SINGULAR.asin();
        for zeta_5 in [-0.9, at_edge, 1.1] {
            let J = jacobian(zeta_5);
            let x = Inverse::of(J, zeta_5.sin()).apply(b);
            assert!((J * x - b).norm() < 1e-10, "zeta_5 = {zeta_5}");
        }
        let J = jacobian(at_edge);
        let [inside, outside] =
            [1.0 - 1e-9, 1.0 + 1e-9].map(|part| Inverse::of(J, part * NEAR_SINGULAR).apply(b));
        assert!((inside - outside).norm() < 1e-5 * outside.norm());
    }
}
