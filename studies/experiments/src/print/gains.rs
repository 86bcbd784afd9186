//! Writes the gains that the rule computes for a machine as an SSP parameter set
//! (`hdrm-fmu machine gains --output`).

use motion_check::gain_rule::RuledGain;

/// What of the template is for actuators as built alone.
const AS_BUILT: [&str; 2] = ["<!-- as built -->\n", "<!-- end -->\n"];

/// The parameter set `name` with these gains, for the system `Real.ssp` or, `is_ideal`, for
/// `Manipulator.ssp`.
pub fn parameter_set(name: &str, machine: &str, gains: &[RuledGain], is_ideal: bool) -> String {
    let (mut reasons, mut parameters) = (String::new(), String::new());
    for gain in gains {
        reasons += &format!("       {}: {}\n", gain.name, gain.why);
        parameters += &format!(
            "    <ssv:Parameter name=\"controller.{}\"><ssv:Real value=\"{}\" unit=\"{}\"/></ssv:Parameter>\n",
            gain.name, gain.value, gain.unit
        );
    }
    let template = include_str!("gains.ssv");
    let template = match is_ideal {
        false => AS_BUILT
            .iter()
            .fold(template.to_owned(), |text, mark| text.replace(mark, "")),
        true => {
            let [before, rest] = AS_BUILT.map(|mark| template.split_once(mark).expect("marked"));
            format!("{}{}", before.0, rest.1)
                .replace("  </ssv:Units>", concat!(
                    "    <ssc:Unit name=\"V/A\"><ssc:BaseUnit kg=\"1\" m=\"2\" s=\"-3\" A=\"-2\"/></ssc:Unit>\n",
                    "    <ssc:Unit name=\"V/N\"><ssc:BaseUnit m=\"1\" s=\"-1\" A=\"-1\"/></ssc:Unit>\n",
                    "  </ssv:Units>",
                ))
                .replace("Real.ssd", "SystemStructure.ssd")
                .replace("gains {machine}`", "gains {machine} (world ideal)`")
                .replace(" for actuators as built with current loops of their own", " for actuators that the controller knows")
                .replace("     The drives regulate their currents themselves; readings are one step of 1 ms old; speeds come from a tracking observer. ", "    ")
        }
    };
    template
        .replace("{reasons}", &reasons)
        .replace("{gains}", &parameters)
        .replace("{name}", name)
        .replace("{machine}", machine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::Machine;
    use motion_check::gain_rule::gains;
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
        assert_eq!(written, set("real_hiab_xs031.ssv"));
    }
}
