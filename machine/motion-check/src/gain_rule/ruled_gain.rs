//! A gain of the rule, and the controller's gains by their names.

use machine_file::Controller;

/// A gain of the controller as the rule gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct RuledGain {
    /// Variable of the controller.
    pub name: &'static str,
    /// Value; for actuators as built of two digits.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
    /// How the value comes about, in words.
    pub why: String,
}

/// Puts gains of the ideal world into a controller's.
pub fn take(controller: &mut Controller, gains: &[RuledGain]) {
    for RuledGain { name, value, .. } in gains {
        *place(controller, name) = *value;
    }
}

pub(super) fn give(controller: &mut Controller, own: &[(&'static str, f64)]) {
    for (name, value) in own {
        *place(controller, name) = *value;
    }
}

/// Names of the gains that the rule gives in the ideal world.
pub const IDEAL: [&str; 7] = [
    "K_i",
    "K_f",
    "K_v",
    "gamma",
    "Lambda_position",
    "Lambda_orientation",
    "omega_tip",
];

/// A gain of the ideal world by its name.
pub fn gain(controller: &Controller, name: &str) -> f64 {
    let mut copy = *controller;
    *place(&mut copy, name)
}

pub(super) fn place<'a>(controller: &'a mut Controller, name: &str) -> &'a mut f64 {
    match name {
        "K_i" => &mut controller.K_i,
        "K_f" => &mut controller.K_f,
        "K_v" => &mut controller.K_v,
        "gamma" => &mut controller.gamma,
        "Lambda_position" => &mut controller.Lambda_position,
        "Lambda_orientation" => &mut controller.Lambda_orientation,
        "omega_tip" => &mut controller.omega_tip,
        _ => unreachable!("no gain of the ideal world: {name}"),
    }
}

/// `value` rounded to two digits.
pub(super) fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().expect("a number")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_digits() {
        for (value, rounded) in [
            (0.01234, 0.012),
            (12.49, 12.0),
            (987.0, 990.0),
            (999.0, 1000.0),
        ] {
            assert!((two_digits(value) / rounded - 1.0).abs() < 1e-12, "{value}");
        }
    }
}
