//! What bounds the gains of a machine, and the parameter set of the gains that the rule makes of it.
#![allow(non_snake_case)] // the symbols of mechanics

use anyhow::{Context, Result};
use emla::maps;
use hdrm::{Hdrm, Options, State};
use machine::Machine;
use machine::gain_rule::{self, Bounds, RuledGain};
use nalgebra::Matrix2;

/// Stiffness of mounting and pins that is reckoned with, N/m: that of the actuators as built.
pub const MOUNTING: f64 = 6e7;
/// A machine whose adaptation is faster than by the rule by this swings on soft mountings: that is
/// the margin in `gamma` that the rule's gains have on the reference machine.
const MARGIN: f64 = 2.0;

/// The gains of a machine.
///
/// # Errors
/// A mechanism that does not work.
pub fn gains(machine: &Machine) -> Result<Vec<RuledGain>> {
    Ok(gain_rule::gains(machine, &bounds(machine)?))
}

/// What bounds the gains of a machine.
///
/// # Errors
/// A mechanism that does not work, or that stands on nothing.
pub fn bounds(machine: &Machine) -> Result<Bounds> {
    let plant = Hdrm::new(machine, &Options::of(machine))?;
    let zeta = machine.start.zeta;
    let strokes = plant.tree().configuration(&zeta).strokes;
    let rest = State {
        zeta,
        ..State::default()
    };
    let (M, _) = plant.equations_of_motion(&rest);
    let booms: Matrix2<f64> = M.fixed_view::<2, 2>(1, 1).into();
    let springs = [1, 2].map(|k| {
        let inside = 1.0 / maps::stiffness(machine.emla.in_order()[k], strokes[k].x);
        strokes[k].prime.powi(2) / (inside + 1.0 / MOUNTING)
    });
    // ω² of K q = ω² M q are the inverses of the eigenvalues of K^(−1/2) M K^(−1/2).
    let root = Matrix2::from_diagonal(&springs.map(|k| 1.0 / k.sqrt()).into());
    let slowest = (root * booms * root).symmetric_eigenvalues().max();
    let lift = |plant: &Hdrm| plant.holding(&zeta).0[1] * strokes[1].prime;
    let mut square = 0.0;
    for k in 0..machine.bodies.in_order().len() {
        let mut half = machine.clone();
        let body = &mut half.bodies.in_order_mut()[k];
        body.mass *= 0.5;
        let without = Hdrm::new(&half, &Options::of(&half))?;
        square += (2.0 * (lift(&plant) - lift(&without))).powi(2);
    }
    let motor = machine.emla.in_order().map(|p| {
        let per_ampere = 1.5 * f64::from(p.p) * p.lambda_m;
        let load = maps::gear_factor(p, 1.0, 0.0);
        per_ampere / machine.controller.K_i * maps::travel_per_radian(p) / maps::inertia(p, load)
    });
    let fastest = motor.into_iter().reduce(f64::max);
    Ok(Bounds {
        mode: slowest.sqrt().recip(),
        moment: square.sqrt(),
        inertia: booms[(0, 0)],
        motor: fastest.context("no motor")?,
    })
}

/// What is wrong with the adaptation gain `gamma`, J, on a machine; nothing where it has a margin.
///
/// # Errors
/// As of [`gains`].
pub fn too_fast(machine: &Machine, gamma: f64) -> Result<Option<String>> {
    let gains = gains(machine)?;
    let ruled = gains.iter().find(|gain| gain.name == "gamma");
    let ruled = ruled.context("a rule without gamma")?.value;
    Ok((gamma * MARGIN <= ruled).then(|| {
        let hertz = bounds(machine).map_or(f64::NAN, |b| b.mode / std::f64::consts::TAU);
        format!(
            "gamma = {gamma} J adapts faster than the lowest mode of this machine allows, {hertz:.1} Hz on actuators as built, so it may swing: the rule gives \
             gamma = {ruled} J; `hdrm-fmu machine gains FILE --output gains.ssv` writes all gains, `--parameters gains.ssv` takes them"
        )
    }))
}

/// The parameter set of these gains for the system `Real.ssp`, called `name`.
pub fn parameter_set(name: &str, machine: &str, gains: &[RuledGain]) -> String {
    let reason = |gain: &RuledGain| format!("       {}: {}\n", gain.name, gain.why);
    let parameter = |RuledGain {
                         name, value, unit, ..
                     }: &RuledGain| {
        format!(
            "    <ssv:Parameter name=\"controller.{name}\"><ssv:Real value=\"{value}\" unit=\"{unit}\"/></ssv:Parameter>\n"
        )
    };
    let each = |text: &dyn Fn(&RuledGain) -> String| gains.iter().map(text).collect::<String>();
    include_str!("gains.ssv")
        .replace("{reasons}", &each(&reason))
        .replace("{gains}", &each(&parameter))
        .replace("{name}", name)
        .replace("{machine}", machine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn set(name: &str) -> String {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../system/resources");
        std::fs::read_to_string(folder.join(name)).expect("a parameter set")
    }

    /// What ships for the reference machine is what the rule gives; the loader crane's set is the
    /// rule's, letter by letter.
    #[test]
    fn the_shipped_gains_are_those_of_the_rule() {
        let shipped = set("real.ssv");
        for RuledGain {
            name, value, unit, ..
        } in gains(&Machine::reference()).expect("gains")
        {
            let entry =
                format!("\"controller.{name}\"><ssv:Real value=\"{value}\" unit=\"{unit}\"/>");
            assert!(shipped.contains(&entry), "{entry}");
        }
        let crane = Machine::preset("hiab_xs031").expect("a machine");
        let gains = gains(&crane).expect("gains");
        let written = parameter_set("real_hiab_xs031", "hiab_xs031", &gains);
        assert_eq!(written, set("real_hiab_xs031.ssv"));
    }

    /// A load on one spring has ω² = k/M: with the tilt boom and all that it carries made light,
    /// the lower mode is that of the lift boom on its rod, to the part that the light boom weighs.
    #[test]
    fn the_mode_is_that_of_a_load_on_a_spring() {
        let mut machine = Machine::reference();
        for body in machine.bodies.in_order_mut().into_iter().skip(4) {
            body.mass *= 1e-5;
            let I = &mut body.inertia_com;
            for moment in [
                &mut I.xx, &mut I.yy, &mut I.zz, &mut I.xy, &mut I.xz, &mut I.yz,
            ] {
                *moment *= 1e-5;
            }
        }
        let bounds = bounds(&machine).expect("bounds");
        let plant = Hdrm::new(&machine, &Options::of(&machine)).expect("a plant");
        let stroke = plant.tree().configuration(&machine.start.zeta).strokes[1];
        let screw = maps::stiffness(&machine.emla.lift, stroke.x);
        let spring = stroke.prime.powi(2) / (1.0 / screw + 1.0 / MOUNTING);
        let expected = (spring / bounds.inertia).sqrt();
        let found = bounds.mode / expected;
        assert!((found - 1.0).abs() < 1e-3, "{found}");
    }

    /// The longer boom with 500 kg asks for slower adaptation than the reference machine's gains
    /// have; a reference machine with another name does not.
    #[test]
    fn a_machine_that_asks_for_other_gains_is_told() {
        let mut machine = Machine::reference();
        assert_eq!(too_fast(&machine, 250.0).expect("works"), None);
        machine.geometry.r_B_B4[0] = 2.1;
        machine.bodies.PL.mass = 500.0;
        let text = too_fast(&machine, 250.0).expect("works").expect("a cause");
        assert!(
            text.contains("lowest mode") && text.contains("machine gains"),
            "{text}"
        );
        assert_eq!(too_fast(&machine, 900.0).expect("works"), None);
    }
}
