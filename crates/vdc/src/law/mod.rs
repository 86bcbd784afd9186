//! Control laws: from the required motion to the forces of rods and wrist joints.
//!
//! A law is one file, a value of [`Mode`] and its rows in [`MODES`]; what it is asked stands in [`ControlLaw`].

mod control_law;
mod decomposition;
mod model_based;
mod pd;

pub(crate) use control_law::{Instant, Rod};
pub(crate) use decomposition::{BodyMotion, ground, motions, velocity_errors};

use control_law::ControlLaw;
use model_based::ModelBased;
use pd::Pd;
use serde::{Deserialize, Serialize};

/// Which control law is at work.
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
}

impl Mode {
    /// The law.
    pub(crate) fn law(self) -> &'static dyn ControlLaw {
        match self {
            Self::Adaptive => &ModelBased { adapts: true },
            Self::Modular => &ModelBased { adapts: false },
            Self::Pd => &Pd {
                holds_weight: false,
            },
            Self::PdGravity => &Pd { holds_weight: true },
        }
    }
}

/// A law as users choose it.
#[derive(Clone, Copy, Debug)]
pub struct NamedMode {
    /// Its name.
    pub name: &'static str,
    /// What it is, for people.
    pub description: &'static str,
    /// Its law.
    pub mode: Mode,
    /// Whether the integral of the tip's error acts.
    pub integral: bool,
}

const fn named(
    name: &'static str,
    mode: Mode,
    integral: bool,
    description: &'static str,
) -> NamedMode {
    NamedMode {
        name,
        description,
        mode,
        integral,
    }
}

/// All laws under their names, in the order of their numbers from 1; new ones are added at the end.
#[rustfmt::skip] // a law a line
pub const MODES: [NamedMode; 8] = [
    named("adaptive", Mode::Adaptive, false, "model-based, with natural adaptation of the inertias"),
    named("modular", Mode::Modular, false, "model-based, with the nominal inertias"),
    named("pd", Mode::Pd, false, "no model: inverse kinematics, damping and decoupling only"),
    named("modular_integral", Mode::Modular, true, "as modular, with the integral of the tip's error"),
    named("pd_integral", Mode::Pd, true, "as pd, with the integral of the tip's error"),
    named("pd_gravity", Mode::PdGravity, false, "as pd, with the forces that hold the nominal machine against gravity"),
    named("pd_gravity_integral", Mode::PdGravity, true, "as pd_gravity, with the integral of the tip's error"),
    named("adaptive_integral", Mode::Adaptive, true, "as adaptive, with the integral of the tip's error"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracking::RodMotion;
    use machine::Machine;

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
                assert_ne!(a.name, b.name);
                assert_ne!((a.mode, a.integral), (b.mode, b.integral), "{}", a.name);
            }
        }
    }
}
