//! Cascade control as in industrial drives, a mode for comparison with the paper's laws: position
//! P, velocity PI, with feedforward of nominal gravity and friction.
//!
//! Source: R. Krishnan, *Permanent Magnet Synchronous and Brushless DC Motor Drives*, chapter on
//! speed control. The position loop is that of the tip (`Lambda_position`, `Lambda_orientation`);
//! its rates are the references of the joints' velocity loops, whose proportional gains are the
//! `pd_…` dampings and whose integral rate is `omega_tip`. The voltage law is the current loop.

use crate::law::control_law::{ControlLaw, Forces, Instant, Rod};
use crate::law::decomposition;
use crate::law::pd::Pd;

pub(crate) struct Cascade;

impl ControlLaw for Cascade {
    fn forces(&self, now: &Instant) -> Forces {
        let hold =
            decomposition::holding_forces(now.configuration, &now.bodies.estimates, now.ground);
        let gains = now.gains;
        // Proportional part of the velocity loop of each joint, N·m.
        let proportional: [f64; 6] = std::array::from_fn(|i| {
            let lacking = now.required.zeta_dot[i] - now.zeta_dot[i];
            let gain = match i.checked_sub(3) {
                None => gains.pd_actuator_damping * now.configuration.strokes[i].prime.powi(2),
                Some(j) => gains.pd_wrist_damping[j],
            };
            gain * lacking
        });
        let torque = |i: usize| {
            let friction = now.nominal.joint_viscous[i] * now.required.zeta_dot[i];
            hold[i] + friction + proportional[i] + now.law_integral[i]
        };
        Forces {
            law_integral_rate: proportional.map(|p| gains.omega_tip * p),
            ..now.forces_from_joints(std::array::from_fn(torque))
        }
    }

    fn rod_force(&self, rod: &Rod) -> f64 {
        Pd { holds_weight: true }.rod_force(rod)
    }
}
