//! Systems of the Open Simulation Platform (`OspSystemStructure.xml`), which `cosim` runs and
//! converts: [`convert`] writes them as a system structure of SSP. Directions and types come from
//! the FMUs' model descriptions, groups of variables from files `OspModelDescription.xml`.
//!
//! Values pass as they are, whatever the units of their ends, as in the platform's own programs.

mod connections;
mod groups;
mod simulator;

use std::collections::{HashMap, HashSet};
use std::fmt::Write;

use fmi_description::xml::{Element, XmlError, quoted};
use fmi_description::{Causality, Kind};

use connections::Wire;
use simulator::{Simulator, parts, unknown};

pub use simulator::{Model, Models};

/// Base step where a structure names none, s.
const BASE_STEP: f64 = 0.1;

/// A system of the platform as a system structure of SSP.
pub struct Converted {
    /// Text of the `.ssd`.
    pub text: String,
    /// What is done otherwise than the file says.
    pub remarks: Vec<String>,
}

/// Converts the text of the file `file`. `model` gives the FMU of a simulator, by its name and
/// source.
///
/// # Errors
/// What is wrong or not supported, with its line.
pub fn convert(text: &str, file: &str, model: &mut Models<'_>) -> Result<Converted, XmlError> {
    let root = Element::parse(text, file, "OspSystemStructure")?;
    let text = text.trim_start_matches('\u{feff}');
    if let Some(version) = root.get("version").filter(|version| *version != "0.1") {
        return Err(root.error(format!("version `{version}` is not supported, only 0.1")));
    }
    let mut known = HashSet::new();
    for part in &root.children {
        match part.tag.as_str() {
            "Description" | "StartTime" | "EndTime" | "BaseStepSize" | "Algorithm"
            | "Simulators" | "Functions" | "Connections" | "EccoConfiguration" => {}
            _ => return Err(unknown(part)),
        }
        if !known.insert(&part.tag) {
            return Err(part.error(format!("{} is there twice", part.tag)));
        }
    }
    let number = |tag: &str| {
        let Some(part) = root.child(tag) else {
            return Ok(None);
        };
        let content = content(text, part);
        let number = content.parse().ok().filter(|x: &f64| x.is_finite());
        let unfit = || {
            part.error(format!(
                "{tag} is `{content}`; it must be a finite number, s"
            ))
        };
        number.map(Some).ok_or_else(unfit)
    };
    let (start, stop) = (number("StartTime")?.unwrap_or(0.0), number("EndTime")?);
    let base = number("BaseStepSize")?.unwrap_or(BASE_STEP);
    if let (Some(part), true) = (root.child("BaseStepSize"), base <= 0.0) {
        return Err(part.error(format!("BaseStepSize is {base} s; it must be above 0")));
    }
    if let (Some(part), Some(stop)) = (root.child("EndTime"), stop.filter(|stop| *stop < start)) {
        let text = format!("EndTime is {stop} s, before the start at {start} s");
        return Err(part.error(text));
    }
    let mut remarks = Vec::new();
    if let Some(part) = root.child("Algorithm") {
        let name = content(text, part);
        match name.to_lowercase().as_str() {
            "fixedstep" => {}
            "ecco" => remarks.push(format!(
                "Algorithm `{name}` chooses steps by power bonds, which is not supported: steps are fixed, BaseStepSize = {base} s; \
                 --doubling-tolerance chooses steps by their error"
            )),
            _ => {
                return Err(part.error(format!(
                    "Algorithm is `{name}`; it must be fixedStep or ecco"
                )));
            }
        }
    }
    let mut simulators = Vec::new();
    for node in parts(&root, "Simulators", &["Simulator"])? {
        let simulator = Simulator::read(node, base, model, &mut remarks)?;
        let mut others = simulators.iter();
        if others.any(|other: &Simulator| other.name == simulator.name) {
            let text = format!("two simulators are named `{}`", simulator.name);
            return Err(node.error(text));
        }
        simulators.push(simulator);
    }
    let wires = connections::read(&root, &simulators, &mut remarks)?;
    let times = (start, stop, base);
    let text = write(&simulators, &wires, times).map_err(|e| root.error(e.to_string()))?;
    Ok(Converted { text, remarks })
}

/// The text in an element.
fn content<'t>(text: &'t str, element: &Element) -> &'t str {
    let whole = text.get(element.range.clone()).unwrap_or_default();
    let begin = whole.find('>').map_or(whole.len(), |at| at + 1);
    let end = whole.rfind("</").unwrap_or(begin).max(begin);
    whole[begin..end].trim()
}

fn write(
    simulators: &[Simulator],
    wires: &[Wire],
    (start, stop, base): (f64, Option<f64>, f64),
) -> Result<String, std::fmt::Error> {
    let mut used: HashMap<usize, Vec<&str>> = HashMap::new();
    let mut seen = HashSet::new();
    let ends = wires.iter().flat_map(|wire| [&wire.from, &wire.to]);
    for (k, variable) in ends.filter(|end| seen.insert(*end)) {
        used.entry(*k).or_default().push(variable);
    }
    let mut text = String::from(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="OspSystemStructure">
<ssd:System name="OspSystemStructure">
<ssd:Elements>
"#,
    );
    for (k, simulator) in simulators.iter().enumerate() {
        let source = quoted(&simulator.model.source);
        let name = quoted(&simulator.name);
        writeln!(text, "<ssd:Component name={name} source={source}>")?;
        writeln!(text, "<ssd:Connectors>")?;
        for variable in used.get(&k).into_iter().flatten() {
            let description = &simulator.model.description;
            let Ok(found) = description.variable(variable) else {
                continue;
            };
            let kind = match found.causality {
                Causality::Input => "input",
                Causality::Parameter => "parameter",
                Causality::CalculatedParameter => "calculatedParameter",
                _ => "output",
            };
            let data_type = match found.kind {
                Kind::Enumeration(_) => "Integer",
                _ => found.kind.name(),
            };
            let name = quoted(variable);
            writeln!(
                text,
                "<ssd:Connector name={name} kind=\"{kind}\"><ssc:{data_type}/></ssd:Connector>"
            )?;
        }
        writeln!(text, "</ssd:Connectors>")?;
        if !simulator.values.is_empty() {
            text += "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>\n<ssv:ParameterSet version=\"1.0\" name=\"initialValues\"><ssv:Parameters>\n";
            for (name, data_type, value) in &simulator.values {
                let [name, value] = [name, value].map(|text| quoted(text));
                writeln!(
                    text,
                    "<ssv:Parameter name={name}><ssv:{data_type} value={value}/></ssv:Parameter>"
                )?;
            }
            text += "</ssv:Parameters></ssv:ParameterSet>\n</ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>\n";
        }
        if let Some(step) = simulator.step {
            let rate = annotation("rate", &format!("<Rate step=\"{step:?}\"/>"));
            writeln!(text, "{rate}")?;
        }
        text += "</ssd:Component>\n";
    }
    text += "</ssd:Elements>\n<ssd:Connections>\n";
    for wire in wires {
        let end = |(k, variable): &(usize, String), which: &str| {
            let [element, variable] = [&simulators[*k].name, variable].map(|text| quoted(text));
            format!("{which}Element={element} {which}Connector={variable}")
        };
        let (from, to) = (end(&wire.from, "start"), end(&wire.to, "end"));
        write!(
            text,
            "<ssd:Connection {from} {to} suppressUnitConversion=\"true\">"
        )?;
        if let Some([factor, offset]) = wire.linear {
            write!(
                text,
                "<ssc:LinearTransformation factor=\"{factor:?}\" offset=\"{offset:?}\"/>"
            )?;
        }
        if wire.is_term {
            text += &annotation("sum", "<Sum/>");
        }
        text += "</ssd:Connection>\n";
    }
    let stop = stop.map_or(String::new(), |stop| format!(" stopTime=\"{stop:?}\""));
    write!(
        text,
        r#"</ssd:Connections>
</ssd:System>
<ssd:DefaultExperiment startTime="{start:?}"{stop}><ssd:Annotations><ssc:Annotation type="com.opensimulationplatform"><osp:Algorithm xmlns:osp="http://opensimulationplatform.com/SSP/OSPAnnotations"><osp:FixedStepAlgorithm baseStepSize="{base:?}"/></osp:Algorithm></ssc:Annotation></ssd:Annotations></ssd:DefaultExperiment>
</ssd:SystemStructureDescription>
"#
    )?;
    Ok(text)
}

/// An annotation that `cosim` knows.
fn annotation(kind: &str, content: &str) -> String {
    format!(
        "<ssd:Annotations><ssc:Annotation type=\"io.github.hdrm-fmu.{kind}\">{content}</ssc:Annotation></ssd:Annotations>"
    )
}
