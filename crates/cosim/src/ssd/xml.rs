//! The elements of the file as they stand; only what is read.
#![allow(missing_docs)] // named like the elements and attributes

use anyhow::{Result, bail};
use quick_xml::events::Event;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::PowerBond;

/// Read a text whose outermost element is `root`; the error never repeats more than the beginning of it.
pub fn read<T: DeserializeOwned>(text: &str, root: &str) -> Result<T> {
    if !text.trim_start().starts_with('<') {
        bail!("it is no XML");
    }
    let mut events = quick_xml::Reader::from_str(text);
    let first = loop {
        match events.read_event() {
            Ok(Event::Start(element) | Event::Empty(element)) => break element,
            Ok(Event::Eof) | Err(_) => bail!("it has no elements"),
            Ok(_) => {}
        }
    };
    if first.local_name().as_ref() != root {
        bail!("its outermost element is not {root}");
    }
    quick_xml::de::from_str(text).map_err(|e| {
        let reason: String = e.to_string().chars().take(200).collect();
        anyhow::anyhow!(reason)
    })
}

#[derive(Deserialize)]
pub struct File {
    #[serde(rename = "System")]
    pub system: System,
    #[serde(rename = "DefaultExperiment")]
    pub default_experiment: Option<Experiment>,
}
#[derive(Deserialize)]
pub struct Experiment {
    #[serde(rename = "@startTime")]
    pub start_time: Option<f64>,
    #[serde(rename = "@stopTime")]
    pub stop_time: Option<f64>,
}
#[derive(Deserialize)]
pub struct System {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "Connectors", default)]
    pub connectors: Connectors,
    #[serde(rename = "ParameterBindings", default)]
    pub bindings: Bindings,
    #[serde(rename = "Elements", default)]
    pub elements: Elements,
    #[serde(rename = "Connections", default)]
    pub connections: Connections,
}
#[derive(Default, Deserialize)]
pub struct Elements {
    #[serde(rename = "Component", default)]
    pub components: Vec<Component>,
    #[serde(rename = "System", default)]
    pub systems: Vec<Nested>,
}
#[derive(Deserialize)]
pub struct Nested {
    #[serde(rename = "@name")]
    pub name: String,
}
#[derive(Deserialize)]
pub struct Component {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "@source")]
    pub source: String,
    #[serde(rename = "Connectors", default)]
    pub connectors: Connectors,
    #[serde(rename = "ParameterBindings", default)]
    pub bindings: Bindings,
}
#[derive(Default, Deserialize)]
pub struct Connectors {
    #[serde(rename = "Connector", default)]
    pub connectors: Vec<Connector>,
}
#[derive(Deserialize)]
pub struct Connector {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "@kind")]
    pub kind: String,
    #[serde(rename = "Real")]
    pub real: Option<Real>,
    #[serde(rename = "Integer")]
    pub integer: Option<serde::de::IgnoredAny>,
    #[serde(rename = "Boolean")]
    pub boolean: Option<serde::de::IgnoredAny>,
    #[serde(rename = "String")]
    pub string: Option<serde::de::IgnoredAny>,
    #[serde(rename = "Enumeration")]
    pub enumeration: Option<serde::de::IgnoredAny>,
    #[serde(rename = "Binary")]
    pub binary: Option<serde::de::IgnoredAny>,
}
#[derive(Deserialize)]
pub struct Real {
    #[serde(rename = "@unit")]
    pub unit: Option<String>,
}
#[derive(Default, Deserialize)]
pub struct Bindings {
    #[serde(rename = "ParameterBinding", default)]
    pub bindings: Vec<Binding>,
}
#[derive(Deserialize)]
pub struct Binding {
    #[serde(rename = "@prefix")]
    pub prefix: Option<String>,
    #[serde(rename = "@source")]
    pub source: Option<String>,
    #[serde(rename = "@sourceBase")]
    pub source_base: Option<String>,
    #[serde(rename = "ParameterMapping")]
    pub mapping: Option<serde::de::IgnoredAny>,
    #[serde(rename = "ParameterValues")]
    pub values: Option<Values>,
}
#[derive(Deserialize)]
pub struct Values {
    #[serde(rename = "ParameterSet")]
    pub set: Set,
}
#[derive(Deserialize)]
pub struct Set {
    #[serde(rename = "Parameters")]
    pub parameters: Parameters,
}
#[derive(Deserialize)]
pub struct Parameters {
    #[serde(rename = "Parameter", default)]
    pub parameters: Vec<Parameter>,
}
#[derive(Deserialize)]
pub struct Parameter {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "Real")]
    pub real: Option<Value>,
    #[serde(rename = "Integer")]
    pub integer: Option<Value>,
    #[serde(rename = "Boolean")]
    pub boolean: Option<Value>,
    #[serde(rename = "String")]
    pub string: Option<Value>,
    #[serde(rename = "Enumeration")]
    pub enumeration: Option<Value>,
}
#[derive(Deserialize)]
pub struct Value {
    #[serde(rename = "@value")]
    pub value: String,
    #[serde(rename = "@unit")]
    pub unit: Option<String>,
}
#[derive(Default, Deserialize)]
pub struct Connections {
    #[serde(rename = "Connection", default)]
    pub connections: Vec<Connection>,
}
#[derive(Deserialize)]
pub struct Connection {
    #[serde(rename = "@startElement")]
    pub start_element: Option<String>,
    #[serde(rename = "@startConnector")]
    pub start_connector: String,
    #[serde(rename = "@endElement")]
    pub end_element: Option<String>,
    #[serde(rename = "@endConnector")]
    pub end_connector: String,
    #[serde(rename = "@suppressUnitConversion", default)]
    pub units_stay: bool,
    #[serde(rename = "LinearTransformation")]
    pub linear: Option<LinearTransformation>,
    #[serde(
        rename = "BooleanMappingTransformation",
        alias = "IntegerMappingTransformation",
        alias = "EnumerationMappingTransformation"
    )]
    pub mapped: Option<serde::de::IgnoredAny>,
    #[serde(rename = "Annotations", default)]
    pub annotations: Annotations,
}
#[derive(Deserialize)]
pub struct LinearTransformation {
    #[serde(rename = "@factor")]
    pub factor: Option<String>,
    #[serde(rename = "@offset")]
    pub offset: Option<String>,
}
#[derive(Default, Deserialize)]
pub struct Annotations {
    #[serde(rename = "Annotation", default)]
    pub annotations: Vec<Annotation>,
}
#[derive(Deserialize)]
pub struct Annotation {
    #[serde(rename = "@type")]
    pub kind: String,
    #[serde(rename = "PowerBond")]
    pub bond: Option<PowerBond>,
}
