//! Required joint motion, for `tracking`, from joints' errors under commanded rates or in a stop.

use crate::reference::JointTarget;
use crate::tracking::errors::Errors;
use crate::tracking::required::RequiredMotion;
use hdrm::DOF;
use nalgebra::Vector6;

/// Error of the joints, rad: the reference a time `age`, s, ago minus the measured angles.
pub(crate) fn error(target: &JointTarget, zeta: &[f64; DOF], age: f64) -> Vector6<f64> {
    let motion = target.motion;
    motion.zeta - motion.zeta_dot * age - Vector6::from(*zeta)
}

/// Required joint motion by the feedback Λ on the joints' errors and their integral, limited to the
/// largest rate of each joint.
pub(crate) fn required(
    target: &JointTarget,
    errors: &Errors,
    zeta_dot: &[f64; DOF],
    age: f64,
    [position, orientation]: [f64; 2],
) -> RequiredMotion {
    let motion = target.motion;
    let Lambda = Vector6::from_fn(|i, _| if i < 3 { position } else { orientation });
    let seen = motion.zeta_dot - motion.zeta_ddot * age;
    let e_dot = seen - Vector6::from(*zeta_dot);
    let mut required = RequiredMotion {
        zeta_dot: motion.zeta_dot + Lambda.component_mul(&(errors.e + errors.z)),
        zeta_ddot: motion.zeta_ddot + Lambda.component_mul(&(e_dot + errors.z_dot)),
    };
    for i in 0..DOF {
        let (rate, largest) = (required.zeta_dot[i], target.rate_max[i]);
        if rate.abs() > largest {
            required.zeta_dot[i] = largest.copysign(rate);
            let inwards = required.zeta_ddot[i] * rate < 0.0;
            required.zeta_ddot[i] *= f64::from(u8::from(inwards));
        }
    }
    required
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Motion;

    /// Required motion by its equation, `ζ̇_d + Λ (e + z)` and its rate; a joint that would exceed
    /// its largest rate is held to it, and not accelerated beyond.
    #[test]
    fn required_rates_follow_the_reference_and_keep_the_limits() {
        let motion = Motion {
            zeta: Vector6::new(0.1, 0.7, -0.9, 0.2, -0.8, 0.3),
            zeta_dot: Vector6::new(0.1, -0.2, 0.3, 0.1, 0.4, -0.4),
            zeta_ddot: Vector6::new(0.5, 0.25, -0.5, 1.0, 2.0, 2.0),
            ..Motion::default()
        };
        let target = JointTarget {
            motion: &motion,
            rate_max: &[0.5; DOF],
        };
        let errors = Errors {
            e: Vector6::new(0.01, 0.02, -0.03, 0.04, 0.05, -0.05),
            z: Vector6::new(0.02, -0.01, 0.01, 0.02, 0.05, -0.05),
            z_dot: Vector6::new(0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
        };
        let zeta_dot = [0.3, 0.1, -0.2, 0.4, 0.1, -0.1];
        let age = 0.1;
        let found = required(&target, &errors, &zeta_dot, age, [2.0, 4.0]);
        for (i, measured) in zeta_dot.into_iter().enumerate() {
            let Lambda = if i < 3 { 2.0 } else { 4.0 };
            let (v, a) = (motion.zeta_dot[i], motion.zeta_ddot[i]);
            let rate = v + Lambda * (errors.e[i] + errors.z[i]);
            let acceleration = a + Lambda * (v - age * a - measured + errors.z_dot[i]);
            let (rate, acceleration) = match i {
                // Both would go at 0.8 rad/s: one faster still, the other slower.
                4 => (0.5, 0.0),
                5 => (-0.5, acceleration),
                _ => (rate, acceleration),
            };
            assert!((found.zeta_dot[i] - rate).abs() < 1e-15, "{i}: {found:?}");
            let error = (found.zeta_ddot[i] - acceleration).abs();
            assert!(error < 1e-14, "{i}: {found:?} {acceleration}");
        }
        assert!(found.zeta_ddot[5] > 0.0);

        let zeta = std::array::from_fn(|i| motion.zeta[i] - 0.02);
        let error = error(&target, &zeta, age);
        for i in 0..DOF {
            let expected = 0.02 - age * motion.zeta_dot[i];
            assert!((error[i] - expected).abs() < 1e-15);
        }
    }
}
