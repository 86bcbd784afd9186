//! Control laws, for `controller`: from the required motion to the forces of rods and wrist joints.
//!
//! A law is a file that implements [`ControlLaw`], a value of [`Mode`] and its rows in [`MODES`].
//! It adapts the estimates in [`Bodies`](crate::bodies::Bodies); [`State`](crate::state::State) has
//! an integral for each joint, and fields for further states.

mod cascade;
mod control_law;
mod decomposition;
mod friction;
mod model_based;
mod observer;
mod pd;
mod reference_bounds;
mod sliding;

pub(crate) use control_law::{Instant, Rod};
pub(crate) use decomposition::{
    BodyMotion, ground, hook_model, motions, own_inertia, shared_momentum, velocity_errors,
    whole_inertia,
};
pub(crate) use friction::{TurningJoint, WristFriction};
pub(crate) use reference_bounds::reference_bounds;

use cascade::Cascade;
use control_law::ControlLaw;
use model_based::ModelBased;
use observer::DisturbanceObserver;
use pd::Pd;
use serde::{Deserialize, Serialize};
use sliding::SuperTwisting;

/// The control law.
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
    /// Position P, velocity PI, gravity and friction fed forward.
    Cascade,
    /// Model-based with the nominal parameters and a disturbance observer at the joints.
    DisturbanceObserver,
    /// Model-based with the nominal parameters and super-twisting.
    SuperTwisting,
}

impl Mode {
    pub(crate) fn law(self) -> &'static dyn ControlLaw {
        match self {
            Self::Adaptive => &ModelBased { adapts: true },
            Self::Modular => &ModelBased { adapts: false },
            Self::Pd => &Pd {
                holds_weight: false,
            },
            Self::PdGravity => &Pd { holds_weight: true },
            Self::Cascade => &Cascade,
            Self::DisturbanceObserver => &DisturbanceObserver,
            Self::SuperTwisting => &SuperTwisting,
        }
    }
}

/// The values of the parameter `mode`, numbered from 1: a law, whether the integral of the tip's
/// error acts, name and description. New rows are appended.
#[rustfmt::skip] // a law a line
pub const MODES: [((Mode, bool), &str, &str); 11] = [
    ((Mode::Adaptive, false), "adaptive", "model-based, with natural adaptation of the inertias"),
    ((Mode::Modular, false), "modular", "model-based, with the nominal inertias"),
    ((Mode::Pd, false), "pd", "no model: inverse kinematics, damping and decoupling only"),
    ((Mode::Modular, true), "modular_integral", "as modular, with the integral of the tip's error"),
    ((Mode::Pd, true), "pd_integral", "as pd, with the integral of the tip's error"),
    ((Mode::PdGravity, false), "pd_gravity", "as pd, with the forces that hold the nominal machine against gravity"),
    ((Mode::PdGravity, true), "pd_gravity_integral", "as pd_gravity, with the integral of the tip's error"),
    ((Mode::Adaptive, true), "adaptive_integral", "as adaptive, with the integral of the tip's error"),
    ((Mode::Cascade, false), "cascade", "position P, velocity PI of each joint (integral rate omega_tip), gravity and friction fed forward"),
    ((Mode::DisturbanceObserver, false), "disturbance_observer", "as modular, with a disturbance observer of bandwidth omega_tip at the joints"),
    ((Mode::SuperTwisting, false), "super_twisting", "as modular, with a super-twisting sliding mode (integral rate omega_tip) at the joints"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracking::RodMotion;
    use machine_file::Machine;

    /// The force of a rod by itself in numbers whose parts are told apart by their powers of ten.
    #[test]
    fn the_force_of_a_rod_has_all_its_parts() {
        let mut gains = Machine::reference().controller;
        (gains.kappa_KA, gains.pd_actuator_damping) = (3.0, 5.0);
        let rod = Rod {
            gains: &gains,
            M_act: 16.0,
            required: &RodMotion {
                x_r_dot: 0.8125,
                x_r_ddot: 25.5,
            },
            x_dot: 0.25,
            f_d: 4096.0,
        };
        let lacking = 0.8125 - 0.25;
        let model_based = 4096.0 + 16.0 * 25.5 + 16.0 * 3.0 * lacking;
        for (mode, expected) in [
            (Mode::Adaptive, model_based),
            (Mode::Modular, model_based),
            (Mode::Pd, 5.0 * lacking),
            (Mode::PdGravity, 4096.0 + 5.0 * lacking),
        ] {
            assert_eq!(mode.law().rod_force(&rod), expected, "{mode:?}");
        }
    }

    #[test]
    fn each_name_is_another_law() {
        for (k, a) in MODES.iter().enumerate() {
            for b in &MODES[k + 1..] {
                assert_ne!(a.1, b.1);
                assert_ne!(a.0, b.0, "{}", a.1);
            }
        }
    }
}
