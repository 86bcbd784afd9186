//! Writes the gains that the rule computes for a machine as an SSP parameter set
//! (`hdrm-fmu machine gains --output`).

use anyhow::Result;
use motion_check::gain_rule::RuledGain;

use super::element::Element;

/// What the parameter set says first.
const ABOUT: &str = " Gains by the rule of docs/machine/machines.md, each with its reason. ";
/// Units with their exponents of base units.
const UNITS: [(&str, &[(&str, i32)]); 8] = [
    ("1", &[]),
    ("1/s", &[("s", -1)]),
    ("s", &[("s", 1)]),
    ("rad/s", &[("rad", 1), ("s", -1)]),
    ("J", &[("kg", 1), ("m", 2), ("s", -2)]),
    ("V.s/m", &[("kg", 1), ("m", 1), ("s", -2), ("A", -1)]),
    ("V/A", &[("kg", 1), ("m", 2), ("s", -3), ("A", -2)]),
    ("V/N", &[("m", 1), ("s", -1), ("A", -1)]),
];

/// The parameter set `name` with these gains of a machine, for the system `Real.ssp` or, `is_ideal`,
/// for `Manipulator.ssp`.
pub fn parameter_set(
    name: &str,
    machine: &str,
    gains: &[RuledGain],
    is_ideal: bool,
) -> Result<String> {
    let gains = gains.iter().map(|gain| {
        let name = format!("controller.{}", gain.name);
        real(&name, gain.value, gain.unit, &gain.why)
    });
    let as_built = (!is_ideal).then(as_built).into_iter().flatten();
    let units = UNITS.map(|(name, powers)| {
        let base = Element::new("ssc:BaseUnit");
        let base = (powers.iter()).fold(base, |base, (unit, power)| base.with(unit, power));
        Element::new("ssc:Unit").with("name", name).holding([base])
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
            Element::new("ssv:Parameters").holding(gains.chain(as_built)),
            Element::new("ssv:Units").holding(units),
        ]);
    set.file(ABOUT)
}

/// What the systems with actuators as built have besides.
fn as_built() -> [Element; 9] {
    let boolean = |name| {
        let value = Element::new("ssv:Boolean").with("value", true);
        parameter(name, "the drives regulate their currents themselves", value)
    };
    let observer = Element::new("ssv:Integer").with("value", 3);
    [
        real(
            "controller.reading_age",
            0.001,
            "s",
            "readings are one step of 1 ms old",
        ),
        real(
            "controller.weighing_time",
            0.5,
            "s",
            "the wrist shows whether the hook is empty",
        ),
        real("controller.force_limit", 1.2, "1", "of the rated forces"),
        boolean("controller.current_loop"),
        boolean("emla_1.current_loop"),
        boolean("emla_2.current_loop"),
        boolean("emla_3.current_loop"),
        parameter(
            "sensors.speed",
            "speeds come from a tracking observer",
            observer,
        ),
        real(
            "sensors.speed.bandwidth_motor",
            1200.0,
            "rad/s",
            "four times that at the joints",
        ),
    ]
}

fn real(name: &str, value: f64, unit: &str, why: &str) -> Element {
    let value = Element::new("ssv:Real").with("value", value);
    parameter(name, why, value.with("unit", unit))
}

fn parameter(name: &str, why: &str, value: Element) -> Element {
    Element::new("ssv:Parameter")
        .with("name", name)
        .with("description", why)
        .holding([value])
}

#[cfg(test)]
mod tests {
    use super::parameter_set;
    use fmi_description::xml::Element;
    use machine_file::Machine;
    use motion_check::gain_rule::{RuledGain, gains};
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

    /// A machine's file may have any name.
    #[test]
    fn any_name_gives_xml() {
        let name = "a--b & <c>";
        let set = parameter_set(name, name, &[], false).expect("a set");
        let read = Element::parse(&set, "set", "ParameterSet").expect("XML");
        assert_eq!(read.get("name"), Some(name));
    }
}
