//! The laws that take part in the tournament, with the gains that are tuned.

use tip_path::SIX_JOINTS;

/// Paths on which gains are tuned.
pub const TUNING_PATHS: [&str; 2] = ["triangular", SIX_JOINTS];

const TIP: &[&str] = &["Lambda_position"];
const TURN: &[&str] = &["Lambda_orientation"];
const KAPPA: &[&str] = &["kappa_KA"];
const INTEGRAL: &[&str] = &["omega_tip"];
const RODS: &[&str] = &["pd_actuator_damping"];
const WRIST: &[&str] = &[
    "pd_wrist_damping[1]",
    "pd_wrist_damping[2]",
    "pd_wrist_damping[3]",
];
const MODULAR: &[&[&str]] = &[TIP, TURN, KAPPA, INTEGRAL];
const DAMPED: &[&[&str]] = &[TIP, TURN, RODS, WRIST, INTEGRAL];

/// The machine file of the controller of each machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    Nominal,
    /// The one that was identified for it.
    Identified,
    /// The plant's own.
    True,
}

/// A law and the groups of gains that are tuned; a group has one factor.
pub struct Contestant {
    pub name: &'static str,
    /// Mode of the controller.
    pub(super) mode: &'static str,
    pub model: Model,
    pub(super) gains: &'static [&'static [&'static str]],
}

impl Contestant {
    const fn new(mode: &'static str, gains: &'static [&'static [&'static str]]) -> Self {
        Self {
            name: mode,
            mode,
            model: Model::Nominal,
            gains,
        }
    }
}

/// All laws.
pub const CONTESTANTS: [Contestant; 9] = [
    Contestant::new(
        "adaptive_integral",
        &[TIP, TURN, KAPPA, INTEGRAL, &["gamma"]],
    ),
    Contestant::new("adaptive", &[TIP, TURN, KAPPA, &["gamma"]]),
    Contestant::new("modular_integral", MODULAR),
    Contestant {
        name: "modular_integral_identified",
        model: Model::Identified,
        ..Contestant::new("modular_integral", MODULAR)
    },
    // No controller can have this: it bounds what a model of the machine may bring.
    Contestant {
        name: "modular_integral_true",
        model: Model::True,
        ..Contestant::new("modular_integral", MODULAR)
    },
    Contestant::new("pd_gravity_integral", DAMPED),
    Contestant::new("cascade", DAMPED),
    Contestant::new("disturbance_observer", MODULAR),
    Contestant::new("super_twisting", MODULAR),
];
