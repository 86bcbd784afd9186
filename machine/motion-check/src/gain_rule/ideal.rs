//! The gains for actuators that the controller knows, of [`super`].

use super::bounds::{Bounds, bounds_on};
use super::error::GainError;
use super::feedback::{LEAST_FEEDBACK, largest_feedback, least_damped};
use super::ruled_gain::{RuledGain, gain, give, place};
use emla::maps;
use hdrm::HdrmError;
use machine_file::{Controller, Emla, Machine};

/// Steps between the lightest and the heaviest motor in which `K_v` is searched.
const SPREAD_STEPS: u32 = 6;

/// The gains of a machine whose actuators are those that the controller knows; the reference
/// machine's are its own, bit for bit. A gain that the machine's file says, different from the
/// reference machine's, is kept and not listed.
/// ```text
/// K_i ~ L_q   K_f ~ K_i/β₁   K_v ~ K_f J (2πN/ρ)²   γ ~ Σ (m g x)²/(M ω²)   κ, ω_d, ω_i, T as they are
/// ```
/// `Lambda_position` is the reference machine's, or the largest with which every mode of the loop
/// (`drive_loop`) has the damping ratio of 10 %; where that is below 5 1/s, the largest up to
/// it with 5 %. One controller has one set of gains for its three drives: that with the
/// smallest inductance, the largest force per current and the lightest motor bounds them.
pub fn ideal_gains(machine: &Machine) -> Result<Vec<RuledGain>, GainError> {
    ideal_gains_beside(machine, &[])
}

/// The gains in the ideal world for a user who gives `own` values to some: these count in place of
/// the file's, and are not listed.
pub fn ideal_gains_beside(
    machine: &Machine,
    own: &[(&'static str, f64)],
) -> Result<Vec<RuledGain>, GainError> {
    let reference = Machine::reference();
    let known = &reference.controller;
    let mut gains = machine.controller;
    give(&mut gains, own);
    // What differs from the reference machine's is said by the file.
    let is_said = |gains: &Controller, name: &str| {
        own.iter().any(|(said, _)| *said == name) || gain(gains, name) != gain(known, name)
    };
    let mut ruled = Vec::new();
    let mut rule = |gains: &mut Controller, name, unit, value: f64, why: String| {
        if is_said(gains, name) {
            return;
        }
        *place(gains, name) = value;
        ruled.push(RuledGain {
            name,
            value,
            unit,
            why,
        });
    };
    let least = |of: fn(&Emla) -> f64| {
        let each = machine.emla.in_order().map(of);
        each.into_iter().fold(f64::INFINITY, f64::min) / of(&reference.emla.lift)
    };
    let inductance = least(|p| p.L_q);
    let why = "current loop as fast as the reference machine's".to_owned();
    rule(&mut gains, "K_i", "V/A", known.K_i * inductance, why);
    let current = gains.K_i / known.K_i * least(|p| maps::beta_1(p, 0.0).recip());
    let why = format!("K_i = {} for the force of an ampere", gains.K_i);
    rule(&mut gains, "K_f", "V/N", known.K_f * current, why);
    let inertia = |p: &Emla| maps::inertia(p, 1.0) / maps::travel_per_radian(p).powi(2);
    let light = gains.K_f / known.K_f * least(inertia);
    let each = machine.emla.in_order().map(inertia);
    let most = each.into_iter().fold(0.0, f64::max) / inertia(&reference.emla.lift);
    let spread = most / least(inertia);
    // Of unlike motors the lightest would leave the others' booms undamped: what lets the tip be
    // fed back most, between the lightest and the heaviest.
    let mut best = (f64::NEG_INFINITY, known.K_v * light);
    for step in 0..=SPREAD_STEPS {
        let K_v = known.K_v * light * libm::pow(spread, f64::from(step) / f64::from(SPREAD_STEPS));
        let tried = Controller { K_v, ..gains };
        let (feedback, _) = largest_feedback(machine, &tried)?;
        if feedback > best.0 {
            best = (feedback, K_v);
        }
        if spread == 1.0 {
            break;
        }
    }
    let why =
        "motor loop as fast as the reference machine's, for the inertia at the rod".to_owned();
    rule(&mut gains, "K_v", "V.s/m", best.1, why);
    let moments = |machine: &Machine| -> Result<f64, HdrmError> {
        let Bounds {
            mode,
            moment,
            inertia,
            ..
        } = bounds_on(machine, f64::INFINITY)?;
        Ok(moment * moment / (inertia * mode * mode))
    };
    let moments = moments(machine)? / moments(&reference)?;
    let why = "moments of gravity over inertia and mode".to_owned();
    rule(&mut gains, "gamma", "J", known.gamma * moments, why);
    let (feedback, mode) = largest_feedback(machine, &gains)?;
    if !is_said(&gains, "Lambda_position") && feedback < LEAST_FEEDBACK {
        gains.Lambda_position = LEAST_FEEDBACK;
        let as_tried = Machine {
            controller: gains,
            ..machine.clone()
        };
        let is_own = |name: &&str| ruled.iter().all(|gain| gain.name != *name);
        let own = ["K_i", "K_f", "K_v", "gamma"].into_iter().filter(is_own);
        let (mode, _) = least_damped(&as_tried)?;
        return Err(GainError::Undamped(mode, own.collect()));
    }
    // Gains that are said have others that fit them.
    let feedback = match is_said(&gains, "Lambda_position") {
        true => gains.Lambda_position,
        false => feedback,
    };
    let why = format!(
        "least damped mode {:.1} % at {:.1} Hz",
        100.0 * mode.damping,
        mode.hertz
    );
    let turn = feedback / known.Lambda_position * known.Lambda_orientation;
    rule(&mut gains, "Lambda_position", "1/s", feedback, why);
    let part = format!(
        "{} of Lambda_position",
        known.Lambda_orientation / known.Lambda_position
    );
    rule(&mut gains, "Lambda_orientation", "1/s", turn, part);
    let tip = feedback / known.Lambda_position * known.omega_tip;
    let part = format!(
        "{} of Lambda_position",
        known.omega_tip / known.Lambda_position
    );
    rule(&mut gains, "omega_tip", "1/s", tip, part);
    Ok(ruled)
}

/// The gains by the rule ([`ideal_gains`]) of those that the machine's file says.
pub fn said(machine: &Machine) -> Result<Vec<RuledGain>, GainError> {
    let silent = Machine {
        controller: Machine::reference().controller,
        ..machine.clone()
    };
    let mut ruled = ideal_gains(&silent)?;
    ruled
        .retain(|rule| gain(&machine.controller, rule.name) != gain(&silent.controller, rule.name));
    Ok(ruled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gain_rule::tests::{geared, value};

    /// In every digit: the golden tables of the ideal world hold with them.
    #[test]
    fn the_reference_machine_keeps_its_gains() {
        let reference = Machine::reference();
        let own = &reference.controller;
        let ruled = ideal_gains(&reference).expect("gains");
        assert_eq!(ruled.len(), 7);
        for (name, shipped) in [
            ("K_i", own.K_i),
            ("K_f", own.K_f),
            ("K_v", own.K_v),
            ("gamma", own.gamma),
            ("Lambda_position", own.Lambda_position),
            ("Lambda_orientation", own.Lambda_orientation),
            ("omega_tip", own.omega_tip),
        ] {
            assert_eq!(value(&ruled, name), shipped, "{name}");
        }
        let (mode, _) = least_damped(&reference).expect("a mode");
        assert!((mode.damping - 0.128).abs() < 5e-4, "{mode:?}");
    }

    /// A gain that differs from the reference machine's is the user's, and the others fit it.
    #[test]
    fn a_gain_that_the_file_says_is_kept() {
        let mut machine = geared(10.0, 0.016);
        machine.controller.K_f = 2e-4;
        let gains = ideal_gains(&machine).expect("gains");
        assert!(gains.iter().all(|gain| gain.name != "K_f"));
        let inertia = |m: &Machine| {
            let p = &m.emla.lift;
            maps::inertia(p, 1.0) / maps::travel_per_radian(p).powi(2)
        };
        let known = Machine::reference();
        let expected = known.controller.K_v / known.controller.K_f * 2e-4 * inertia(&machine)
            / inertia(&known);
        assert!((value(&gains, "K_v") / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn shipped_machines_have_gains_in_both_worlds() {
        for name in ["sized", "hiab_xs031"] {
            let machine = Machine::preset(name).expect("shipped");
            let ideal = ideal_gains(&machine).expect("gains");
            let feedback = value(&ideal, "Lambda_position");
            assert!(feedback > 10.0, "{name}: {feedback}");
        }
    }
}
