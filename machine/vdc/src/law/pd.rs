//! Control laws, two modes for comparison, without a model of the dynamics: damping of the rate
//! errors behind the inverse kinematics, with or without gravity compensation.

use crate::law::control_law::{ControlLaw, Forces, Instant, Rod};
use crate::law::decomposition;
use hdrm::DOF;

pub(crate) struct Pd {
    /// Whether the nominal weight is compensated.
    pub(crate) holds_weight: bool,
}

impl ControlLaw for Pd {
    fn forces(&self, now: &Instant) -> Forces {
        let Q = if self.holds_weight {
            decomposition::holding_forces(now.configuration, &now.bodies.estimates, now.ground)
        } else {
            [0.0; DOF]
        };
        let gains = now.gains;
        let rod = |i: usize| {
            let prime = now.configuration.strokes[i].prime;
            let x_dot = prime * now.zeta_dot[i];
            Q[i] / prime + gains.pd_actuator_damping * (now.rods[i].x_r_dot - x_dot)
        };
        let wrist = |j: usize| {
            let error = now.required.zeta_dot[3 + j] - now.zeta_dot[3 + j];
            Q[3 + j] + gains.pd_wrist_damping[j] * error
        };
        Forces {
            rods: std::array::from_fn(rod),
            wrist: std::array::from_fn(wrist),
            ..Forces::default()
        }
    }

    fn rod_force(&self, rod: &Rod) -> f64 {
        let damping = rod.gains.pd_actuator_damping * (rod.required.x_r_dot - rod.x_dot);
        if self.holds_weight {
            rod.f_d + damping
        } else {
            damping
        }
    }

    fn knows_actuators(&self) -> bool {
        false
    }
}
