//! System structures (`.ssd`): systems, their elements, connectors, connections and parameter
//! bindings. `cosim` flattens them into components and connections.

use std::collections::HashSet;

use fmi_description::xml::{self, XmlError};

use crate::connector::{Connector, Units, read_connectors};
use crate::dictionary::{DictionaryReference, SignalDictionary};
use crate::parameters::{Binding, Sourced};
use crate::transformation::Transformation;

/// A system structure.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemStructure {
    /// The outermost system.
    pub system: System,
    /// Start and stop times of a run, unless the user gives others.
    pub default_experiment: DefaultExperiment,
}

/// `DefaultExperiment`; times in s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DefaultExperiment {
    /// Start time.
    pub start: Option<f64>,
    /// Stop time.
    pub stop: Option<f64>,
    /// Annotations of tools.
    pub annotations: Vec<Annotation>,
}

/// An annotation: content for the tools that know its type.
#[derive(Clone, Debug, PartialEq)]
pub struct Annotation {
    /// Type, in reverse domain notation.
    pub kind: String,
    /// XML element of the annotation.
    pub content: xml::Element,
}

impl Annotation {
    fn read_all(node: &xml::Element) -> Result<Vec<Self>, XmlError> {
        let read = |content: &xml::Element| {
            let kind = content.required("type")?;
            Ok(Self {
                kind,
                content: content.clone(),
            })
        };
        node.listed("Annotations", "Annotation").map(read).collect()
    }
}

/// A system: elements, connectors to the outside, and the connections between them.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// Name.
    pub name: String,
    /// Connectors to the enclosing system.
    pub connectors: Vec<Connector>,
    /// Parameter values, in the order in which they are applied.
    pub bindings: Vec<Binding>,
    /// Components, systems and references to dictionaries, in the order of the file.
    pub elements: Vec<Element>,
    /// Connections, in the order of the file.
    pub connections: Vec<Connection>,
    /// Signal dictionaries by name.
    pub dictionaries: Vec<(String, Sourced<SignalDictionary>)>,
    /// Annotations of tools.
    pub annotations: Vec<Annotation>,
}

/// An element of a system.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    /// An FMU, or a structure in another file.
    Component(Component),
    /// A system.
    System(System),
    /// A reference to a signal dictionary.
    Dictionary(DictionaryReference),
}

impl Element {
    /// Name.
    pub fn name(&self) -> &str {
        match self {
            Self::Component(c) => &c.name,
            Self::System(s) => &s.name,
            Self::Dictionary(d) => &d.name,
        }
    }

    /// Connectors.
    pub fn connectors(&self) -> &[Connector] {
        match self {
            Self::Component(c) => &c.connectors,
            Self::System(s) => &s.connectors,
            Self::Dictionary(d) => &d.connectors,
        }
    }
}

/// Kind of a component's source file, attribute `type`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// An FMU.
    #[default]
    Fmu,
    /// Another system structure, `.ssd`.
    Structure,
    /// A packed system, `.ssp`.
    Package,
}

/// An element that has a source file.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Name.
    pub name: String,
    /// Source file, relative to the structure.
    pub source: String,
    /// Kind of the file.
    pub kind: Kind,
    /// Interface of the FMU that is to be used; None for any.
    pub implementation: Option<Implementation>,
    /// Declared variables.
    pub connectors: Vec<Connector>,
    /// Parameter values, in the order in which they are applied.
    pub bindings: Vec<Binding>,
    /// Annotations of tools.
    pub annotations: Vec<Annotation>,
}

/// An interface of an FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Implementation {
    /// Co-Simulation.
    CoSimulation,
    /// Model Exchange.
    ModelExchange,
}

/// One end of a connection: a connector of an element, or of the system itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct End {
    /// Name of the element; None for the system itself.
    pub element: Option<String>,
    /// Name of the connector.
    pub connector: String,
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.element {
            Some(element) => write!(f, "{element}.{}", self.connector),
            None => f.write_str(&self.connector),
        }
    }
}

/// A connection. The directions of the connectors decide which end the values come from, not the
/// names `start` and `end`.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// One end.
    pub start: End,
    /// The other end.
    pub end: End,
    /// Transformation of the values.
    pub transformation: Option<Transformation>,
    /// `suppressUnitConversion`: units are not converted.
    pub keeps_units: bool,
    /// Annotations of tools.
    pub annotations: Vec<Annotation>,
    /// Line in the file, for messages.
    pub line: usize,
}

impl SystemStructure {
    /// Read the text of a `.ssd`; `file` is its name for messages.
    pub fn parse(text: &str, file: &str) -> Result<Self, XmlError> {
        let root = xml::Element::parse(text, file, "SystemStructureDescription")?;
        if let Some(version) = root.get("version")
            && !["1.0", "2.0"].contains(&version)
        {
            return Err(root.error(format!(
                "version `{version}` of SSP is not supported, only 1.0 and 2.0"
            )));
        }
        let Some(system) = root.child("System") else {
            return Err(root.error("it has no System".into()));
        };
        let experiment = root.child("DefaultExperiment");
        let experiment = experiment.map(|node| {
            Ok(DefaultExperiment {
                start: node.finite("startTime")?,
                stop: node.finite("stopTime")?,
                annotations: Annotation::read_all(node)?,
            })
        });
        Ok(Self {
            system: read_system(system, &Units::read(&root)?)?,
            default_experiment: experiment.transpose()?.unwrap_or_default(),
        })
    }
}

fn read_system(node: &xml::Element, units: &Units) -> Result<System, XmlError> {
    let name = node.required("name")?;
    let (mut elements, mut names) = (Vec::new(), HashSet::new());
    for child in node.child("Elements").into_iter().flat_map(|e| &e.children) {
        let element = match child.tag.as_str() {
            "Component" => Element::Component(read_component(child, units)?),
            "System" => Element::System(read_system(child, units)?),
            "SignalDictionaryReference" => Element::Dictionary(DictionaryReference {
                name: child.required("name")?,
                dictionary: child.required("dictionary")?,
                connectors: read_connectors(child, units)?,
            }),
            _ => continue,
        };
        if !names.insert(element.name().to_string()) {
            let what = match element {
                Element::Component(_) => "components",
                _ => "elements",
            };
            return Err(child.error(format!(
                "system `{name}` has two {what} named `{}`",
                element.name()
            )));
        }
        elements.push(element);
    }
    let connections = node.listed("Connections", "Connection");
    let connections = connections.map(read_connection);
    let dictionaries = node.listed("SignalDictionaries", "SignalDictionary");
    let dictionaries = dictionaries.map(|dictionary| {
        let inline = |node: &xml::Element| {
            let inline = node.child("SignalDictionary");
            inline.map(SignalDictionary::read).transpose()
        };
        let name = dictionary.required("name")?;
        Ok((
            name,
            Sourced::read(dictionary, "a signal dictionary", inline)?,
        ))
    });
    Ok(System {
        connectors: read_connectors(node, units)?,
        bindings: Binding::read_all(node)?,
        annotations: Annotation::read_all(node)?,
        connections: connections.collect::<Result<_, _>>()?,
        dictionaries: dictionaries.collect::<Result<_, _>>()?,
        elements,
        name,
    })
}

fn read_component(node: &xml::Element, units: &Units) -> Result<Component, XmlError> {
    let (name, source) = (node.required("name")?, node.required("source")?);
    let kind = match node.get("type") {
        None | Some("application/x-fmu-sharedlibrary") => Kind::Fmu,
        Some("application/x-ssp-definition") => Kind::Structure,
        Some("application/x-ssp-package") => Kind::Package,
        Some(other) => {
            return Err(node.error(format!(
                "component `{name}` is of the type `{other}`, which is not supported"
            )));
        }
    };
    let implementation = match node.get("implementation") {
        None | Some("any") => None,
        Some("CoSimulation") => Some(Implementation::CoSimulation),
        Some("ModelExchange") => Some(Implementation::ModelExchange),
        Some(other) => {
            return Err(node.error(format!(
                "component `{name}` asks for the implementation `{other}`; CoSimulation and ModelExchange are supported"
            )));
        }
    };
    Ok(Component {
        name,
        source,
        kind,
        implementation,
        connectors: read_connectors(node, units)?,
        bindings: Binding::read_all(node)?,
        annotations: Annotation::read_all(node)?,
    })
}

fn read_connection(node: &xml::Element) -> Result<Connection, XmlError> {
    let end = |element, connector| {
        // OMSimulator writes an empty name for the system itself.
        let element = node.get(element).filter(|name| !name.is_empty());
        Ok(End {
            element: element.map(str::to_string),
            connector: node.required(connector)?,
        })
    };
    let connection = Connection {
        start: end("startElement", "startConnector")?,
        end: end("endElement", "endConnector")?,
        transformation: Transformation::read(node)?,
        keeps_units: node.flag("suppressUnitConversion")?,
        annotations: Annotation::read_all(node)?,
        line: node.line,
    };
    let indices = node.get("startIndices").or(node.get("endIndices"));
    if indices.is_some() {
        return Err(node.error(format!(
            "connection {} -> {}: connections of some elements of an array (indices) are not supported",
            connection.start, connection.end
        )));
    }
    Ok(connection)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connector::{DataType, Direction};

    const TEXT: &str = r#"<?xml version="1.0"?>
<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" xmlns:ssv="v" version="1.0" name="s">
 <ssd:DefaultExperiment startTime="0.5"/>
 <ssd:System name="s">
  <ssd:Connections>
   <ssd:Connection startElement="a" startConnector="y" endElement="in" endConnector="u" suppressUnitConversion="1"/>
   <ssd:Connection startConnector="x" endElement="a" endConnector="u"><ssc:LinearTransformation factor="2"/></ssd:Connection>
  </ssd:Connections>
  <ssd:Connectors><ssd:Connector name="x" kind="input"><ssc:Float64 unit="mm"/></ssd:Connector></ssd:Connectors>
  <ssd:Elements>
   <ssd:Component name="a" source="A.fmu"><ssd:Connectors><ssd:Connector name="y" kind="output"/>
    <ssd:Connector name="m" kind="parameter"><ssc:Enumeration name="Mode"/></ssd:Connector></ssd:Connectors></ssd:Component>
   <!-- a comment among the elements -->
   <ssd:System name="in"><ssd:Elements><ssd:Component name="b" source="B.ssp" type="application/x-ssp-package"/></ssd:Elements></ssd:System>
   <ssd:Component name="c" source="C.fmu"/>
   <ssd:SignalDictionaryReference name="bus" dictionary="Bus"/>
  </ssd:Elements>
  <ssd:SignalDictionaries><ssd:SignalDictionary name="Bus" source="bus.ssb"/></ssd:SignalDictionaries>
  <ssd:SystemGeometry x1="0" y1="0" x2="1" y2="1"/>
 </ssd:System>
 <ssd:Units><ssc:Unit name="mm"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit></ssd:Units>
 <ssd:Enumerations><ssc:Enumeration name="Mode"><ssc:Item name="off" value="0"/><ssc:Item name="on" value="2"/></ssc:Enumeration></ssd:Enumerations>
</ssd:SystemStructureDescription>"#;

    #[test]
    fn every_order_of_elements_is_read() {
        let read = SystemStructure::parse(TEXT, "s.ssd").unwrap();
        let names: Vec<_> = read.system.elements.iter().map(Element::name).collect();
        assert_eq!(names, ["a", "in", "c", "bus"]);
        assert_eq!(read.default_experiment.start, Some(0.5));
        let outer = &read.system.connectors[0];
        assert_eq!(
            (outer.data_type, outer.direction),
            (Some(DataType::Real), Direction::Input)
        );
        assert_eq!(outer.unit.as_ref().map(|u| u.factor), Some(0.001));
        let connectors = read.system.elements[0].connectors();
        assert_eq!((connectors[0].data_type, connectors[0].line), (None, 11));
        assert_eq!(connectors[1].data_type, Some(DataType::Enumeration));
        let [plain, scaled] = &read.system.connections[..] else {
            panic!("two connections")
        };
        assert!(plain.keeps_units && plain.end.to_string() == "in.u");
        let linear = Transformation::Linear {
            factor: 2.0,
            offset: 0.0,
        };
        assert_eq!((scaled.start.element.as_ref(), scaled.line), (None, 7));
        assert_eq!(scaled.transformation, Some(linear));
        let Element::System(inner) = &read.system.elements[1] else {
            panic!("a system")
        };
        assert!(matches!(&inner.elements[0], Element::Component(c) if c.kind == Kind::Package));
        assert_eq!(read.system.dictionaries[0].0, "Bus");
    }

    /// Each edit makes one thing wrong; the message says what and on which line.
    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (old, new, expected) in [
            (
                "name=\"c\" source",
                "name=\"a\" source",
                "line 15: system `s` has two components named `a`",
            ),
            (
                "kind=\"output\"",
                "kind=\"out\"",
                "line 11: connector `y` is of the unknown kind `out`",
            ),
            (
                " source=\"C.fmu\"",
                "",
                "line 15: Component has no attribute source",
            ),
            (
                "x-ssp-package",
                "x-modelica",
                "line 14: component `b` is of the type `application/x-modelica`",
            ),
            (
                "factor=\"2\"",
                "factor=\"NaN\"",
                "line 7: LinearTransformation with factor NaN",
            ),
            (
                "Conversion=\"1\"",
                "Conversion=\"yes\"",
                "line 6: Connection has suppressUnitConversion = `yes`",
            ),
            (
                "startTime=\"0.5\"",
                "startTime=\"now\"",
                "line 3: DefaultExperiment has startTime = `now`",
            ),
            (
                "m=\"1\" factor",
                "m=\"1.5\" factor",
                "line 21: unit `mm`: the exponent m = `1.5`",
            ),
            (
                "version=\"1.0\" name",
                "version=\"3.0\" name",
                "line 2: version `3.0` of SSP",
            ),
            ("kind=\"output\"/>", "kind=\"output\">", "it is no XML"),
            (
                "startElement=\"a\"",
                "startElement=\"a\" startIndices=\"1\"",
                "(indices) are not supported",
            ),
        ] {
            assert!(TEXT.contains(old), "{old}");
            let error = SystemStructure::parse(&TEXT.replace(old, new), "s.ssd").unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
