//! Makes the variants of a system structure that `pack` packs with it, so that the wiring is
//! written once: parameter sets bound, loads connected, outputs delayed, actuators as built and
//! others. Changes are located in the structure's tree; the rest of its text stays as it is.

use std::ops::Range;

use anyhow::{Context, Result, ensure};
use fmi_description::xml::Element;

/// Trajectories and the times at which their motion ends, s (`tests/test_parameter_sets.py`
/// compares them with the controller's).
const TRAJECTORIES: [(&str, &str); 2] = [("cubic", "24.25"), ("triangular", "13.75")];
const MODES: [&str; 3] = ["adaptive", "modular", "pd"];

/// Bindings of the controller, and of the whole system, which only one system has.
const CONTROLLER: &str = "System Elements Component@controller ParameterBindings ParameterBinding";
const WHOLE: &str = "System ParameterBindings";

/// Components, and the parameter sets that stand in them.
const COMPONENT: &str = "System Elements Component";
const SET: &str = "ParameterBindings ParameterBinding ParameterValues ParameterSet";
/// Outputs act one communication step later than they are computed, as with importers that exchange
/// values once a step; for components that have `alpha`, in systems whose sensors have no delay.
const DELAY: &str = r#"<ssv:Parameter name="delay"><ssv:Integer value="1"/></ssv:Parameter>"#;

/// The component of systems fed by a battery, which have a variant with the actuators as built.
const BATTERY: &str = "System Elements Component@resources/DcLink.fmu";

/// The load at the end-effector, which the path gives: outputs of the controller that are inputs of
/// the manipulator, with units. The structures do not connect it, so that they accept a plant
/// without these inputs.
const LOAD: [(&str, &str); 4] = [
    ("load.mass", "kg"),
    ("load.com[1]", "m"),
    ("load.com[2]", "m"),
    ("load.com[3]", "m"),
];
/// The unit that only the load needs.
const KILOGRAM: &str = r#"<ssc:Unit name="kg"><ssc:BaseUnit kg="1"/></ssc:Unit>"#;

/// File names and texts of the variants of a structure. Each has its own name in its text, because
/// importers tell the structures of one package apart by name.
pub fn variants(structure: &str) -> Result<Vec<(String, String)>> {
    let root = Element::parse(structure, "structure", "SystemStructureDescription")?;
    let original = Variant {
        text: structure,
        root: &root,
        changes: Vec::new(),
    };
    let (_, default_stop) = TRAJECTORIES[0];
    ensure!(
        original.find("DefaultExperiment")?[0].get("stopTime") == Some(default_stop),
        "the system structure must stop at {default_stop} s, as the cubic trajectory does"
    );
    let mut made = Vec::new();
    for (trajectory, stop) in TRAJECTORIES {
        for mode in MODES {
            let mut variant = original.clone();
            variant.bind(CONTROLLER, trajectory)?;
            variant.bind(CONTROLLER, mode)?;
            variant.set("DefaultExperiment", "stopTime", stop)?;
            made.push(variant.named(&format!("{trajectory}_{mode}"))?);
        }
    }
    made.push(original.clone().with_loads()?.named("loads")?);
    let mut standard = original.clone();
    if original.find(WHOLE).is_ok() {
        let mut bare = original.clone();
        bare.remove(WHOLE)?;
        made.push(bare.named("bare")?);
        standard.bind(&format!("{WHOLE} ParameterBinding"), "real_standard")?;
    } else {
        let alpha = format!("{COMPONENT} {SET} Parameters Parameter@alpha");
        standard.insert_before(&alpha, DELAY)?;
    }
    made.push(standard.named("standard")?);
    if original.find(BATTERY).is_ok() {
        // `Rig` has the connectors and values of `Emla`, except those of the network.
        let mut as_built = original;
        let actuator = format!("{COMPONENT}@resources/Emla.fmu");
        as_built.set(&actuator, "source", "resources/Rig.fmu")?;
        as_built.remove(&format!("{actuator} {SET} Parameters Parameter@alpha"))?;
        as_built.remove(&format!("{actuator} {SET} Units Unit@1"))?;
        as_built.bind(CONTROLLER, "as_built")?;
        made.push(as_built.named("as_built")?);
    }
    Ok(made)
}

/// A structure with changes: parts of its text, and what replaces them.
///
/// A place is a path of tags from the outermost element, which is the empty path; `tag@text` is an
/// element with this name or source.
#[derive(Clone)]
struct Variant<'a> {
    text: &'a str,
    root: &'a Element,
    changes: Vec<(Range<usize>, String)>,
}

impl<'a> Variant<'a> {
    /// The elements at a place, at least one.
    fn find(&self, place: &str) -> Result<Vec<&'a Element>> {
        let mut found = vec![self.root];
        for step in place.split_whitespace() {
            let (tag, text) = step.split_once('@').unwrap_or((step, ""));
            let fits = |e: &&Element| {
                let is_named =
                    text.is_empty() || [e.get("name"), e.get("source")].contains(&Some(text));
                e.tag == tag && is_named
            };
            let children = found.into_iter().flat_map(|e| &e.children);
            found = children.filter(fits).collect();
        }
        ensure!(!found.is_empty(), "the system structure must hold {place}");
        Ok(found)
    }

    /// The line break before an element, and the indentation of its line.
    fn indentation(&self, element: &Element) -> &'a str {
        let before = &self.text[..element.range.start];
        &before[before.rfind('\n').unwrap_or(0)..]
    }

    /// Inserts XML before each element of a place, on its own line.
    fn insert_before(&mut self, place: &str, xml: &str) -> Result<()> {
        for element in self.find(place)? {
            let (start, xml) = (
                element.range.start,
                format!("{xml}{}", self.indentation(element)),
            );
            self.changes.push((start..start, xml));
        }
        Ok(())
    }

    /// Inserts XML after the last element of a place, on its own line.
    fn insert_after(&mut self, place: &str, xml: &str) -> Result<()> {
        let last = self.find(place)?.pop().context("there is one")?;
        let (end, xml) = (last.range.end, format!("{}{xml}", self.indentation(last)));
        self.changes.push((end..end, xml));
        Ok(())
    }

    /// Removes the elements of a place with their lines.
    fn remove(&mut self, place: &str) -> Result<()> {
        for element in self.find(place)? {
            let start = element.range.start - self.indentation(element).len();
            self.changes.push((start..element.range.end, String::new()));
        }
        Ok(())
    }

    /// Changes the value of an attribute of the elements of a place.
    fn set(&mut self, place: &str, attribute: &str, value: &str) -> Result<()> {
        let written = |value: &str| format!(" {attribute}=\"{value}\"");
        for element in self.find(place)? {
            let old = written(&element.required(attribute)?);
            let found = self.text[element.range.clone()].find(&old);
            let found = found.with_context(|| format!("{place} must hold{old}, written so"))?;
            let start = element.range.start + found;
            self.changes
                .push((start..start + old.len(), written(value)));
        }
        Ok(())
    }

    /// Binds a parameter set of the resources after those that are bound already.
    fn bind(&mut self, place: &str, set: &str) -> Result<()> {
        let binding = format!(r#"<ssd:ParameterBinding source="resources/{set}.ssv"/>"#);
        self.insert_after(place, &binding)
    }

    /// Connects the load that the path gives.
    fn with_loads(mut self) -> Result<Self> {
        for (name, unit) in LOAD {
            for (component, kind) in [("controller", "output"), ("hdrm", "input")] {
                self.insert_after(
                    &format!("System Elements Component@{component} Connectors Connector@tau_wrist[3]"),
                    &format!(r#"<ssd:Connector name="{name}" kind="{kind}"><ssc:Real unit="{unit}"/></ssd:Connector>"#),
                )?;
            }
            self.insert_after(
                "System Connections Connection",
                &format!(r#"<ssd:Connection startElement="controller" startConnector="{name}" endElement="hdrm" endConnector="{name}"/>"#),
            )?;
        }
        self.insert_after("Units Unit", KILOGRAM)?;
        Ok(self)
    }

    /// File name and text of the variant, under this name.
    fn named(mut self, name: &str) -> Result<(String, String)> {
        let whole = format!("{}_{name}", self.root.required("name")?);
        self.set("", "name", &whole)?;
        self.changes.sort_by_key(|(range, _)| range.start);
        let (mut text, mut passed) = (String::new(), 0);
        for (range, new) in self.changes {
            text = text + &self.text[passed..range.start] + &new;
            passed = range.end;
        }
        Ok((format!("{name}.ssd"), text + &self.text[passed..]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRUCTURE: &str = include_str!("../../../system/SystemStructure.ssd");

    #[test]
    fn variants_differ_from_the_structure_in_name_two_bindings_and_stop_time() {
        let mut variants = super::variants(STRUCTURE).unwrap();
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
        let variants = super::variants(REAL).unwrap();
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
        let variants = super::variants(ELECTRIC).unwrap();
        let (_, text) = variants.iter().find(|(n, _)| n == "as_built.ssd").unwrap();
        assert_eq!(text.matches("resources/Rig.fmu").count(), 3);
        assert!(!text.contains("Emla.fmu") && text.contains(r#"name="Electric_as_built">"#));
        assert_eq!(text.matches(r#"<ssv:Parameter name="alpha">"#).count(), 1); // the controller's
        // Two lines of each actuator less, a binding more.
        assert_eq!(ELECTRIC.lines().count() - text.lines().count(), 5);
        assert!(
            super::variants(STRUCTURE)
                .unwrap()
                .iter()
                .all(|(n, _)| n != "as_built.ssd")
        );
    }

    #[test]
    fn a_structure_with_another_stop_time_or_without_a_controller_is_refused() {
        let other = STRUCTURE.replace("24.25", "20");
        assert!(
            variants(&other)
                .unwrap_err()
                .to_string()
                .contains("24.25 s")
        );
        let other = STRUCTURE.replace(
            r#"<ssd:Component name="controller""#,
            r#"<ssd:Component name="law""#,
        );
        assert!(
            super::variants(&other)
                .unwrap_err()
                .to_string()
                .contains("Component@controller")
        );
    }
}
