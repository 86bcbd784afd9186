//! Writes the gains that the rule computes for a machine as an SSP parameter set
//! (`hdrm-fmu machine gains --output`).

use anyhow::Result;
use fmi_units::{BASE, Unit};
use motion_check::gain_rule::RuledGain;

use super::element::Element;

/// What the parameter set says first.
const ABOUT: &str = " Gains by the rule of docs/machine/machines.md, each with its reason. ";
/// Numbers that the systems with actuators as built have besides: value, unit and meaning.
const AS_BUILT: [(&str, f64, &str, &str); 4] = [
    (
        "controller.reading_age",
        0.001,
        "s",
        "readings are one step of 1 ms old",
    ),
    (
        "controller.weighing_time",
        0.5,
        "s",
        "the wrist shows whether the hook is empty",
    ),
    ("controller.force_limit", 1.2, "1", "of the rated forces"),
    (
        "sensors.speed.bandwidth_motor",
        1200.0,
        "rad/s",
        "four times that at the joints",
    ),
];

/// The parameter set `name` with these gains of a machine, for the system `Real.ssp` or, `is_ideal`,
/// for `Manipulator.ssp`.
pub fn parameter_set(
    name: &str,
    machine: &str,
    gains: &[RuledGain],
    is_ideal: bool,
) -> Result<String> {
    let mut reals: Vec<_> = (gains.iter())
        .map(|gain| {
            (
                format!("controller.{}", gain.name),
                gain.value,
                gain.unit,
                &*gain.why,
            )
        })
        .collect();
    let mut others = Vec::new();
    if !is_ideal {
        reals.extend(AS_BUILT.map(|(name, value, unit, why)| (name.to_owned(), value, unit, why)));
        others = as_built();
    }
    let mut units: Vec<_> = reals.iter().map(|(_, _, unit, _)| *unit).collect();
    units.sort_unstable();
    units.dedup();
    let reals = reals.iter().map(|(name, value, unit, why)| {
        let value = Element::new("ssv:Real").with("value", value);
        parameter(name, why, value.with("unit", unit))
    });
    let (world, system, actuators) = match is_ideal {
        true => ("ideal", "Manipulator.ssp", "that the controller knows"),
        false => (
            "real",
            "Real.ssp",
            "as built with current loops of their own",
        ),
    };
    let about = format!(
        "{system} with `hdrm-fmu machine gains {machine} --world {world}`: gains for actuators {actuators}"
    );
    let set = Element::new("ssv:ParameterSet")
        .with(
            "xmlns:ssc",
            "http://ssp-standard.org/SSP1/SystemStructureCommon",
        )
        .with(
            "xmlns:ssv",
            "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
        )
        .with("version", "1.0")
        .with("name", name)
        .with("description", about)
        .holding([
            Element::new("ssv:Parameters").holding(reals.chain(others)),
            Element::new("ssv:Units").holding(units.into_iter().map(definition)),
        ]);
    set.file(ABOUT)
}

/// What the systems with actuators as built have besides numbers.
fn as_built() -> Vec<Element> {
    let drives = ["controller", "emla_1", "emla_2", "emla_3"].map(|component| {
        let (name, value) = (
            format!("{component}.current_loop"),
            Element::new("ssv:Boolean"),
        );
        let why = "the drives regulate their currents themselves";
        parameter(&name, why, value.with("value", true))
    });
    let observer = Element::new("ssv:Integer").with("value", 3);
    let speed = parameter(
        "sensors.speed",
        "speeds come from a tracking observer",
        observer,
    );
    drives.into_iter().chain([speed]).collect()
}

/// The unit of this name in terms of base units.
fn definition(name: &'static str) -> Element {
    let unit = Unit::find(name).expect("a unit");
    let powers = BASE.iter().zip(unit.exponents);
    let powers = powers.filter(|(_, power)| *power != 0);
    let base = Element::new("ssc:BaseUnit");
    let base = powers.fold(base, |base, (unit, power)| base.with(unit, power));
    Element::new("ssc:Unit").with("name", name).holding([base])
}

fn parameter(name: &str, why: &str, value: Element) -> Element {
    Element::new("ssv:Parameter")
        .with("name", name)
        .with("description", why)
        .holding([value])
}

#[cfg(test)]
mod tests {
    use super::{Unit, parameter_set};
    use fmi_description::xml::Element;
    use machine_file::Machine;
    use motion_check::gain_rule::{RuledGain, gains, ideal_gains};
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
        let written = parameter_set("real_hiab_xs031", "hiab_xs031", &gains, false);
        assert_eq!(written.expect("a set"), set("real_hiab_xs031.ssv"));
    }

    /// A machine's file may have any name, and each unit is defined, as base units without a factor.
    #[test]
    fn a_set_for_any_machine_is_whole() {
        let name = "a--b & <c>";
        let machine = Machine::reference();
        for (gains, is_ideal) in [(gains(&machine), false), (ideal_gains(&machine), true)] {
            let gains = gains.expect("gains");
            let set = parameter_set(name, name, &gains, is_ideal).expect("a set");
            let read = Element::parse(&set, "set", "ParameterSet").expect("XML");
            assert_eq!(read.get("name"), Some(name));
            let defined: Vec<_> = (read.listed("Units", "Unit"))
                .map(|unit| unit.text("name"))
                .collect();
            for unit in gains.iter().map(|gain| gain.unit) {
                assert!(defined.iter().any(|name| name == unit), "{unit}");
                assert_eq!(Unit::find(unit).map(|unit| unit.factor), Some(1.0));
            }
        }
    }
}
