//! Feedback on the tracking error: from reference and measurements to the control laws' input.

mod clik;
mod errors;
mod joints;
mod required;
mod rods;

pub(crate) use errors::Errors;
pub(crate) use required::{RequiredMotion, RodMotion};
pub(crate) use rods::rod_errors;

use crate::nominal::{Nominal, orientation};
use crate::reference::{DesiredMotion, Target};
use crate::signals::Input;
use clik::TipState;
use hdrm::{DOF, Tip};
use machine_file::Controller as Gains;
use nalgebra::{Vector3, Vector6};

/// Tracking errors, and the required motion of the joints.
pub(crate) struct Tracking {
    pub(crate) errors: Errors,
    /// From the present to the desired orientation of the tip, rad.
    pub(crate) rotation_error: Vector3<f64>,
    pub(crate) required: RequiredMotion,
}

/// Required joint motion to follow `target` with the tip at `tip`; `z` is the integral of the
/// errors, if the mode has one.
pub(crate) fn track(
    target: &Target,
    nominal: &Nominal,
    gains: &Gains,
    z: Option<&Vector6<f64>>,
    tip: &Tip,
    input: &Input,
) -> Tracking {
    let Lambda = [gains.Lambda_position, gains.Lambda_orientation];
    let age = gains.reading_age;
    let with_integral = |e| Errors::new(e, z, gains.omega_tip);
    let desired = &target.tip;
    let now = TipState {
        tip,
        singularities: &nominal.singularities,
        orientation: orientation(&input.zeta),
        zeta: &input.zeta,
        zeta_dot: &input.zeta_dot,
    };
    if let Some(joints) = &target.joints {
        let errors = with_integral(joints::error(joints, &input.zeta, age));
        return Tracking {
            errors,
            rotation_error: clik::rotation_error(&desired.orientation, &now.orientation),
            required: joints::required(joints, &errors, &input.zeta_dot, age, Lambda),
        };
    }
    let seen = match age {
        0.0 => *desired,
        age => desired.earlier(age),
    };
    let errors = with_integral(clik::pose_error(&now, &seen));
    Tracking {
        errors,
        rotation_error: errors.e.fixed_rows::<3>(3).into(),
        required: clik::required(&now, desired, &seen, &errors, Lambda),
    }
}

/// Converts `target` to reference rates of the joints, rad/s, and its integral `z` to an integral
/// of the joints' errors, rad, with the same effect.
pub(crate) fn at_joints(
    target: &Target,
    nominal: &Nominal,
    gains: &Gains,
    z: &Vector6<f64>,
    zeta: &[f64; DOF],
) -> [Vector6<f64>; 2] {
    if let Some(joints) = &target.joints {
        return [joints.motion.zeta_dot, *z];
    }
    let tip = Tip::new(&nominal.tree, &nominal.tree.configuration(zeta));
    let rates = |twist| clik::joint_rates(&tip, &nominal.singularities, zeta, twist);
    let [p, o] = [gains.Lambda_position, gains.Lambda_orientation];
    let Lambda = Vector6::new(p, p, p, o, o, o);
    let DesiredMotion {
        velocity,
        angular_velocity,
        ..
    } = &target.tip;
    let twist = clik::stacked(*velocity, *angular_velocity);
    let z = rates(Lambda.component_mul(z)).component_div(&Lambda);
    [rates(twist), z]
}
