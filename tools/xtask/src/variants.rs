//! Variants of a packed system: its one structure with parameter values bound, made while packing,
//! so that the wiring is written once.

use anyhow::{Context, Result, ensure};

/// The first component of a structure, for which the sets are; they are bound after its own
/// parameter bindings.
const CONTROLLER: &str = r#"<ssd:Component name="controller""#;
/// Where a component's parameter bindings end.
const BINDINGS_END: &str = "        </ssd:ParameterBindings>\n";
/// Trajectories and when their motion ends, s (`tests/test_parameter_sets.py` compares with what
/// the controller says).
const TRAJECTORIES: [(&str, &str); 2] = [("cubic", "24.25"), ("triangular", "13.75")];
/// Controllers.
const MODES: [&str; 3] = ["adaptive", "modular", "pd"];

/// The first value in the set of each component with a delay of its own, in systems whose sensors
/// have none.
const FIRST_VALUE: &str = r#"<ssv:Parameter name="alpha">"#;
/// Outputs act one communication step later than they are computed, as with importers that exchange
/// values once a step.
const DELAY: &str = r#"<ssv:Parameter name="delay"><ssv:Integer value="1"/></ssv:Parameter>"#;

/// What only systems fed by a battery hold; they have a variant with the actuators as built.
const FED: &str = "resources/DcLink.fmu";
/// Parameters of the controller for actuators as built.
const GAINS: &str = r#"<ssd:ParameterBinding source="resources/as_built.ssv"/>"#;
/// The unit that only [`FIRST_VALUE`] of an actuator has.
const ITS_UNIT: &str = r#"<ssc:Unit name="1">"#;

/// Gains for actuators as built, bound to the whole system; only the system that needs them holds
/// this.
const REAL_GAINS: &str = r#"    <ssd:ParameterBindings>
      <ssd:ParameterBinding source="resources/real.ssv"/>
    </ssd:ParameterBindings>
"#;
/// The same, and the delays of masters that exchange values once a step.
const REAL_GAINS_AND_DELAYS: &str = r#"    <ssd:ParameterBindings>
      <ssd:ParameterBinding source="resources/real.ssv"/>
      <ssd:ParameterBinding source="resources/real_standard.ssv"/>
    </ssd:ParameterBindings>
"#;

/// What the path has the end-effector carry, from the controller to the manipulator, with units.
/// The structures have no wires for it, so that a plant which knows of no loads fits in.
const LOAD: [(&str, &str); 4] = [
    ("load.mass", "kg"),
    ("load.com[1]", "m"),
    ("load.com[2]", "m"),
    ("load.com[3]", "m"),
];
/// After which connector the load's are declared: an output of the controller, an input of the
/// manipulator.
const LAST_TORQUE: &str =
    r#"<ssd:Connector name="tau_wrist[3]" kind="KIND"><ssc:Real unit="N.m"/></ssd:Connector>"#;
/// Where connections end.
const CONNECTIONS_END: &str = "    </ssd:Connections>";
/// The load's unit that no structure has without it.
const KILOGRAM: &str = r#"    <ssc:Unit name="kg"><ssc:BaseUnit kg="1"/></ssc:Unit>"#;
/// Where units begin.
const UNITS: &str = "  <ssd:Units>\n";

/// File names and texts of the variants of a structure. Each has a name of its own, because
/// importers keep the structures of one package apart by name.
pub fn of(structure: &str) -> Result<Vec<(String, String)>> {
    let mut made = Vec::new();
    let (_, default_stop) = TRAJECTORIES[0];
    for (trajectory, stop) in TRAJECTORIES {
        for mode in MODES {
            let sets = [trajectory, mode]
                .map(|set| format!(r#"<ssd:ParameterBinding source="resources/{set}.ssv"/>"#));
            let text = bound(structure, &sets)?;
            let stop_time = |stop| format!(r#"stopTime="{stop}""#);
            let text = once(&text, &stop_time(default_stop), &stop_time(stop))?;
            let variant = format!("{trajectory}_{mode}");
            made.push((format!("{variant}.ssd"), named(&text, &variant)?));
        }
    }
    made.push(("loads.ssd".to_string(), loads(structure)?));
    let standard = if structure.contains(REAL_GAINS) {
        let bare = once(structure, REAL_GAINS, "")?;
        made.push(("bare.ssd".to_string(), named(&bare, "bare")?));
        once(structure, REAL_GAINS, REAL_GAINS_AND_DELAYS)?
    } else {
        structure.replace(
            FIRST_VALUE,
            &format!("{DELAY}\n                  {FIRST_VALUE}"),
        )
    };
    made.push(("standard.ssd".to_string(), named(&standard, "standard")?));
    if structure.contains(FED) {
        made.push(("as_built.ssd".to_string(), as_built(structure)?));
    }
    Ok(made)
}

/// The structure with wires for the loads of a path.
fn loads(structure: &str) -> Result<String> {
    let mut text = structure.to_string();
    for kind in ["output", "input"] {
        let last = LAST_TORQUE.replace("KIND", kind);
        let connectors = LOAD.map(|(name, unit)| {
            format!(
                "\n          <ssd:Connector name=\"{name}\" kind=\"{kind}\"><ssc:Real unit=\"{unit}\"/></ssd:Connector>"
            )
        });
        text = once(&text, &last, &format!("{last}{}", connectors.concat()))?;
    }
    let connections = LOAD.map(|(name, _)| {
        format!(
            "      <ssd:Connection startElement=\"controller\" startConnector=\"{name}\" endElement=\"hdrm\" endConnector=\"{name}\"/>\n"
        )
    });
    let connections = format!("{}{CONNECTIONS_END}", connections.concat());
    let text = once(&text, CONNECTIONS_END, &connections)?;
    let text = once(&text, UNITS, &format!("{UNITS}{KILOGRAM}\n"))?;
    named(&text, "loads")
}

/// The structure with `Rig` in the place of `Emla`: the same connectors and values, but for the
/// network, of which `Rig` knows nothing.
fn as_built(structure: &str) -> Result<String> {
    let components = structure.split("<ssd:Component ").map(|component| {
        if !component.contains("resources/Emla.fmu") {
            return component.to_string();
        }
        let of_network = |line: &&str| !line.contains(FIRST_VALUE) && !line.contains(ITS_UNIT);
        let lines: Vec<&str> = component.split('\n').filter(of_network).collect();
        lines.join("\n").replace("Emla.fmu", "Rig.fmu")
    });
    let components: Vec<String> = components.collect();
    let text = bound(&components.join("<ssd:Component "), &[GAINS])?;
    named(&text, "as_built")
}

/// The structure with parameter bindings of the controller after those that it has.
fn bound(structure: &str, bindings: &[impl AsRef<str>]) -> Result<String> {
    let missing = || "the system structure must hold a component `controller` with bindings";
    let (before, controller) = structure.split_once(CONTROLLER).with_context(missing)?;
    let (own, after) = controller.split_once(BINDINGS_END).with_context(missing)?;
    let bindings = bindings
        .iter()
        .map(|binding| format!("          {}\n", binding.as_ref()));
    let bindings: String = bindings.collect();
    Ok([before, CONTROLLER, own, &bindings, BINDINGS_END, after].concat())
}

/// The structure with a name of its own.
fn named(structure: &str, variant: &str) -> Result<String> {
    const BEFORE: &str = r#"version="1.0" name=""#;
    let after = structure.split_once(BEFORE).map(|(_, after)| after);
    let name = after.and_then(|after| after.split_once('"'));
    let (name, _) = name.context("the system structure must have a version 1.0 and a name")?;
    let named = |name: &str| format!(r#"{BEFORE}{name}">"#);
    once(
        structure,
        &named(name),
        &named(&format!("{name}_{variant}")),
    )
}

fn once(text: &str, from: &str, to: &str) -> Result<String> {
    let found = text.matches(from).count();
    ensure!(
        found == 1,
        "the system structure must hold `{from}` once for its variants, but holds it {found} times"
    );
    Ok(text.replace(from, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRUCTURE: &str = include_str!("../../../system/SystemStructure.ssd");

    #[test]
    fn variants_differ_from_the_structure_in_name_two_bindings_and_stop_time() {
        let mut variants = of(STRUCTURE).unwrap();
        assert_eq!(variants.len(), 8);
        let (name, standard) = variants.pop().unwrap();
        assert_eq!(name, "standard.ssd");
        // Controller and three actuators.
        assert_eq!(standard.matches(r#"name="delay""#).count(), 4);
        assert_eq!(standard.lines().count(), STRUCTURE.lines().count() + 4);
        let (name, loads) = variants.pop().unwrap();
        assert_eq!(name, "loads.ssd");
        assert_eq!(loads.matches("load.mass").count(), 4); // two connectors, two ends
        assert_eq!(loads.lines().count(), STRUCTURE.lines().count() + 13);
        assert_eq!(loads.matches(KILOGRAM).count(), 1);
        for (name, text) in variants {
            let (trajectory, mode) = name.strip_suffix(".ssd").unwrap().split_once('_').unwrap();
            let lines: Vec<_> = text
                .lines()
                .filter(|line| !STRUCTURE.lines().any(|l| l == *line))
                .collect();
            assert!(lines[0].contains(&format!(r#"name="Manipulator_{trajectory}_{mode}""#)));
            assert!(lines[1].contains(&format!("resources/{trajectory}.ssv")));
            assert!(lines[2].contains(&format!("resources/{mode}.ssv")));
            assert_eq!(lines.len(), if trajectory == "cubic" { 3 } else { 4 });
        }
    }

    const REAL: &str = include_str!("../../../system/Real.ssd");

    #[test]
    fn the_machine_as_built_has_the_same_variants_under_its_own_name() {
        let variants = of(REAL).unwrap();
        assert_eq!(variants.len(), 9);
        for (name, text) in variants {
            let variant = name.strip_suffix(".ssd").unwrap();
            assert!(text.contains(&format!(r#"name="Real_{variant}">"#)));
            assert!(text.contains(r#"source="resources/real.ssv""#) == (variant != "bare"));
            assert!(text.contains("resources/sensors.ssv"));
        }
    }

    /// Only the lines of the network go, and nobody else's.
    #[test]
    fn a_machine_that_a_battery_feeds_has_a_variant_as_built() {
        const ELECTRIC: &str = include_str!("../../../system/Electric.ssd");
        let variants = of(ELECTRIC).unwrap();
        let (_, text) = variants.iter().find(|(n, _)| n == "as_built.ssd").unwrap();
        assert_eq!(text.matches("resources/Rig.fmu").count(), 3);
        assert!(!text.contains("Emla.fmu") && text.contains(r#"name="Electric_as_built">"#));
        assert_eq!(text.matches(FIRST_VALUE).count(), 1); // the controller's
        // Two lines of each actuator less, a binding more.
        assert_eq!(ELECTRIC.lines().count() - text.lines().count(), 5);
        assert!(
            of(STRUCTURE)
                .unwrap()
                .iter()
                .all(|(n, _)| n != "as_built.ssd")
        );
    }

    #[test]
    fn a_structure_with_another_stop_time_or_another_first_component_is_refused() {
        let other = STRUCTURE.replace("24.25", "20");
        assert!(of(&other).unwrap_err().to_string().contains("times"));
        let other = STRUCTURE.replace(CONTROLLER, r#"<ssd:Component name="law""#);
        assert!(of(&other).unwrap_err().to_string().contains("`controller`"));
    }
}
