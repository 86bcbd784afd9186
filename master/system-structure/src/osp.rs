//! Systems of the Open Simulation Platform (`OspSystemStructure.xml`), which `cosim` runs and
//! converts: [`convert`] writes them as a system structure of SSP. Directions and types come from
//! the FMUs' model descriptions, groups of variables from files `OspModelDescription.xml`.
//!
//! Values pass as they are, whatever the units of their ends, as in the platform's own programs.

mod connections;
mod groups;

use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::sync::Arc;

use fmi_description::xml::{Element, XmlError};
use fmi_description::{Causality, Description, Kind, Variable};

use connections::Wire;

/// Base step where a structure names none, s.
const BASE_STEP: f64 = 0.1;

/// The FMU of a simulator.
pub struct Model {
    /// Its model description, arrays by element.
    pub description: Description,
    /// Name and text of its `OspModelDescription.xml`, if it has one.
    pub groups: Option<(String, String)>,
    /// Source file in the system structure of SSP.
    pub source: String,
}

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
pub fn convert(
    text: &str,
    file: &str,
    model: &mut dyn FnMut(&str, &str) -> Result<Arc<Model>, String>,
) -> Result<Converted, XmlError> {
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
        let simulator = read_simulator(node, base, model, &mut remarks)?;
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

fn unknown(element: &Element) -> XmlError {
    element.error(format!("the element {} is not known here", element.tag))
}

/// The elements in the element `list` of `node`, which must have one of these tags.
fn parts<'a>(node: &'a Element, list: &str, tags: &[&str]) -> Result<Vec<&'a Element>, XmlError> {
    let all: Vec<_> = node.all_in(list).collect();
    match all.iter().find(|part| !tags.contains(&&*part.tag)) {
        Some(other) => Err(unknown(other)),
        None => Ok(all),
    }
}

/// A simulator: an instance of an FMU.
struct Simulator {
    name: String,
    model: Arc<Model>,
    groups: Vec<groups::Group>,
    /// Step of its own, s.
    step: Option<f64>,
    /// Variable, type of SSP and value.
    values: Vec<(String, &'static str, String)>,
}

impl Simulator {
    fn variable(&self, name: &str, node: &Element) -> Result<&Variable, XmlError> {
        let found = self.model.description.variable(name);
        found.map_err(|error| node.error(format!("simulator `{}`: {error}", self.name)))
    }
}

fn read_simulator(
    node: &Element,
    base: f64,
    model: &mut dyn FnMut(&str, &str) -> Result<Arc<Model>, String>,
    remarks: &mut Vec<String>,
) -> Result<Simulator, XmlError> {
    let (name, source) = (node.required("name")?, node.required("source")?);
    if let Some(other) = node.children.iter().find(|c| c.tag != "InitialValues") {
        return Err(unknown(other));
    }
    let step = node.finite("stepSize")?;
    if let Some(step) = step.filter(|step| *step <= 0.0) {
        return Err(node.wrong(format!("has stepSize = {step} s; it must be above 0")));
    }
    // As in the platform's programs: whole steps, of whole nanoseconds.
    let nanoseconds = |time: f64| (time * 1e9).round().max(1.0);
    let step = step.map(|step| {
        let parts = nanoseconds(step) / nanoseconds(base);
        let own = parts.floor().max(1.0) * base;
        if parts != parts.floor() || parts < 1.0 {
            remarks.push(format!(
                "simulator `{name}` has steps of {own} s instead of stepSize = {step} s: whole multiples of BaseStepSize"
            ));
        }
        own
    });
    let found = model(&name, &source);
    let model = found.map_err(|text| node.error(format!("simulator `{name}`: {text}")))?;
    let mut simulator = Simulator {
        groups: match &model.groups {
            Some((file, text)) => groups::read(text, file)?,
            None => Vec::new(),
        },
        name,
        model,
        step: step.filter(|step| *step != base),
        values: Vec::new(),
    };
    for value in parts(node, "InitialValues", &["InitialValue"])? {
        let variable = value.required("variable")?;
        simulator.variable(&variable, value)?;
        let Some(given) = value.children.first() else {
            return Err(value.error(format!("InitialValue of `{variable}` has no value")));
        };
        let text = given.required("value")?;
        let (data_type, is_fit) = match given.tag.as_str() {
            "Real" => ("Real", given.finite("value")?.is_some()),
            "Integer" => ("Integer", given.whole::<i32>("value")?.is_some()),
            "Enumeration" => ("Integer", given.whole::<i32>("value")?.is_some()),
            "Boolean" => ("Boolean", given.flag("value").is_ok()),
            "String" => ("String", true),
            _ => return Err(unknown(given)),
        };
        if !is_fit || value.children.len() > 1 {
            let text = format!(
                "InitialValue of `{variable}` is `{text}`; it must be one {}",
                given.tag
            );
            return Err(value.error(text));
        }
        simulator.values.push((variable, data_type, text));
    }
    Ok(simulator)
}

/// A text as the value of an attribute.
fn quoted(text: &str) -> String {
    let escaped = text.replace('&', "&amp;").replace('<', "&lt;");
    let escaped = escaped.replace('"', "&quot;").replace('\n', "&#10;");
    format!("\"{escaped}\"")
}

fn write(
    simulators: &[Simulator],
    wires: &[Wire],
    (start, stop, base): (f64, Option<f64>, f64),
) -> Result<String, std::fmt::Error> {
    let mut used: HashMap<usize, Vec<&str>> = HashMap::new();
    for (k, variable) in wires.iter().flat_map(|wire| [&wire.from, &wire.to]) {
        let own = used.entry(*k).or_default();
        if !own.contains(&&**variable) {
            own.push(variable);
        }
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
