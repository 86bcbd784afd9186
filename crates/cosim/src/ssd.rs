//! System structure description (SSP 1.0, `SystemStructure.ssd`): components, connections, parameter values.
//!
//! Read is what a flat system of co-simulation FMUs needs; nested systems, signal dictionaries and parameter mappings are refused by name
//! rather than skipped.

mod bond;
mod parameters;
mod xml;

pub use bond::{Power, PowerBond};
pub use parameters::{Parameter, parse_set};

use anyhow::{Context, Result, bail};

use crate::linear::Linear;
use bond::POWER_BOND;

/// One FMU instance of the system; the order in the file is the stepping order of the Gauss–Seidel schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Name of the instance.
    pub name: String,
    /// FMU file relative to the system structure, for example `resources/Emla.fmu`.
    pub source: String,
    /// Declared inputs, outputs and parameters.
    pub connectors: Vec<Connector>,
    /// Start values from the parameter bindings, applied in this order.
    pub parameters: Vec<Parameter>,
}

/// A declared variable of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct Connector {
    /// Variable name in the FMU.
    pub name: String,
    /// `input`, `output`, `parameter`, ….
    pub kind: String,
    /// Declared type, `Real` where none is declared.
    pub data_type: &'static str,
    /// Unit of a real connector.
    pub unit: Option<String>,
}

/// A connection from an output to an input.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// Component and output.
    pub start: (String, String),
    /// Component and input.
    pub end: (String, String),
    /// What becomes of a Real value on its way.
    pub transformation: Linear,
    /// `suppressUnitConversion`: the units of both ends may differ, because the numbers are meant as the transformation leaves them.
    pub units_stay: bool,
    /// Set where the connection carries the effort of a power bond.
    pub bond: Option<PowerBond>,
}

/// What to do about units that differ.
pub(crate) const UNITS: &str = "units are never converted: where the numbers are right as they are, or are made right by a LinearTransformation, \
     the connection must say suppressUnitConversion=\"true\"";

/// Types of connectors that can be connected.
const CONNECTED: [&str; 3] = ["Real", "Integer", "Boolean"];

/// A system: components, connections and the default experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    /// Name of the system.
    pub name: String,
    /// Components in stepping order.
    pub components: Vec<Component>,
    /// Connections in file order.
    pub connections: Vec<Connection>,
    /// Start time of the default experiment, s (0 when absent).
    pub start_time: f64,
    /// Stop time of the default experiment, s.
    pub stop_time: Option<f64>,
}

impl Structure {
    /// Read the text of a `.ssd` file that names no parameter sets in other files.
    pub fn parse(text: &str) -> Result<Self> {
        Self::read(text, |source| bail!("the file `{source}` is not at hand"))
    }

    /// Read the text of a `.ssd` file; `file` gives the text of a parameter set by the name it has there.
    pub fn read(text: &str, mut file: impl FnMut(&str) -> Result<String>) -> Result<Self> {
        let read: xml::File = xml::read(text, "SystemStructureDescription")
            .context("the system structure is not a readable SSP 1.0 description")?;
        let system = read.system;
        if !system.connectors.connectors.is_empty() {
            bail!(
                "system `{}`: connectors of the outer system are not supported",
                system.name
            );
        }
        if let Some(nested) = system.elements.systems.first() {
            bail!(
                "system `{}`: the nested system `{}` is not supported, only components",
                system.name,
                nested.name
            );
        }
        let components = system
            .elements
            .components
            .into_iter()
            .map(|c| component(c, &mut file))
            .collect::<Result<Vec<_>>>()?;
        for (k, c) in components.iter().enumerate() {
            if components[..k].iter().any(|other| other.name == c.name) {
                bail!("the system has two components named `{}`", c.name);
            }
        }
        let connections = system
            .connections
            .connections
            .into_iter()
            .map(connection)
            .collect::<Result<Vec<_>>>()?;
        let (start_time, stop_time) = read
            .default_experiment
            .map_or((0.0, None), |e| (e.start_time.unwrap_or(0.0), e.stop_time));
        let owner = format!("system `{}`", system.name);
        let mut structure = Self {
            name: system.name,
            components,
            connections,
            start_time,
            stop_time,
        };
        structure.check()?;
        for parameter in parameters::bound(system.bindings, &owner, &mut file)? {
            let Some((k, variable)) = structure.split(&parameter.name) else {
                bail!(
                    "{owner}: {}: `{}` is not a variable of one of its components, component.variable",
                    parameter.origin,
                    parameter.name
                );
            };
            let name = variable.to_string();
            structure.components[k]
                .parameters
                .push(Parameter { name, ..parameter });
        }
        Ok(structure)
    }

    /// Component and variable of a name `component.variable`.
    pub fn split<'a>(&self, name: &'a str) -> Option<(usize, &'a str)> {
        let (component, variable) = name.split_once('.')?;
        Some((self.component(component)?, variable))
    }

    /// Index of the component named `name`.
    pub fn component(&self, name: &str) -> Option<usize> {
        self.components.iter().position(|c| c.name == name)
    }

    /// Every connection must end at declared connectors of the right kind and the same unit, every input at most once.
    fn check(&self) -> Result<()> {
        for (k, c) in self.connections.iter().enumerate() {
            let start = self.connector(&c.start, "output")?;
            let end = self.connector(&c.end, "input")?;
            if start.data_type != end.data_type {
                bail!(
                    "connection {c}: the types differ, {} and {}; both ends must be of the same type",
                    start.data_type,
                    end.data_type
                );
            }
            if start.unit != end.unit && !c.units_stay {
                let text = |unit: &Option<String>| unit.clone().unwrap_or_else(|| "none".into());
                bail!(
                    "connection {c}: the units differ, {} and {}; {UNITS}",
                    text(&start.unit),
                    text(&end.unit)
                );
            }
            if c.transformation != Linear::NONE && start.data_type != "Real" {
                bail!(
                    "connection {c}: a LinearTransformation is for Real connectors; these are {}",
                    start.data_type
                );
            }
            if let Some(other) = self.connections[..k]
                .iter()
                .find(|other| other.end == c.end)
            {
                bail!(
                    "input {}.{} is driven twice, by {}.{} and by {}.{}",
                    c.end.0,
                    c.end.1,
                    other.start.0,
                    other.start.1,
                    c.start.0,
                    c.start.1
                );
            }
        }
        Ok(())
    }

    /// Declared type of what a connection carries.
    pub fn carried(&self, connection: &Connection) -> Result<&'static str> {
        Ok(self.connector(&connection.start, "output")?.data_type)
    }

    fn connector(&self, (component, name): &(String, String), kind: &str) -> Result<&Connector> {
        let Some(index) = self.component(component) else {
            bail!("a connection names the component `{component}`, which the system does not have");
        };
        let Some(found) = self.components[index]
            .connectors
            .iter()
            .find(|c| c.name == *name)
        else {
            bail!(
                "component `{component}` declares no connector `{name}`, but a connection uses it"
            );
        };
        if !CONNECTED.contains(&found.data_type) {
            bail!(
                "connector `{component}.{name}` is declared as {}; only connectors of the types {} can be connected",
                found.data_type,
                CONNECTED.join(", ")
            );
        }
        if found.kind != kind {
            bail!(
                "connector `{component}.{name}` is declared as {}, but a connection uses it as {kind}",
                found.kind
            );
        }
        Ok(found)
    }
}

impl std::fmt::Display for Connection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}.{} -> {}.{}",
            self.start.0, self.start.1, self.end.0, self.end.1
        )
    }
}

fn component(c: xml::Component, file: &mut dyn FnMut(&str) -> Result<String>) -> Result<Component> {
    let owner = format!("component `{}`", c.name);
    let parameters = parameters::bound(c.bindings, &owner, file)?;
    let connectors = c.connectors.connectors.into_iter().map(|k| Connector {
        data_type: data_type(&k),
        name: k.name,
        kind: k.kind,
        unit: k.real.and_then(|r| r.unit),
    });
    Ok(Component {
        name: c.name,
        source: c.source,
        connectors: connectors.collect(),
        parameters,
    })
}

fn data_type(connector: &xml::Connector) -> &'static str {
    let types = [
        (connector.integer.is_some(), "Integer"),
        (connector.boolean.is_some(), "Boolean"),
        (connector.string.is_some(), "String"),
        (connector.enumeration.is_some(), "Enumeration"),
        (connector.binary.is_some(), "Binary"),
    ];
    let declared = types.into_iter().find(|(is_it, _)| *is_it);
    declared.map_or("Real", |(_, name)| name)
}

fn connection(c: xml::Connection) -> Result<Connection> {
    let (Some(from), Some(to)) = (c.start_element, c.end_element) else {
        bail!(
            "connection {} -> {}: both ends must name a component",
            c.start_connector,
            c.end_connector
        );
    };
    if c.mapped.is_some() {
        bail!(
            "connection {from}.{} -> {to}.{}: mapping transformations are not supported, only LinearTransformation",
            c.start_connector,
            c.end_connector
        );
    }
    let transformation = transformation(c.linear).with_context(|| {
        format!(
            "connection {from}.{} -> {to}.{}",
            c.start_connector, c.end_connector
        )
    })?;
    let mut bond = None;
    for annotation in c.annotations.annotations {
        let Some(found) = annotation.bond else {
            continue;
        };
        if annotation.kind != POWER_BOND {
            bail!(
                "connection {from}.{} -> {to}.{}: a PowerBond stands in an annotation of type `{}`; the type must be `{POWER_BOND}`",
                c.start_connector,
                c.end_connector,
                annotation.kind
            );
        }
        bond = Some(found);
    }
    Ok(Connection {
        start: (from, c.start_connector),
        end: (to, c.end_connector),
        transformation,
        units_stay: c.units_stay,
        bond,
    })
}

fn transformation(found: Option<xml::LinearTransformation>) -> Result<Linear> {
    let Some(xml::LinearTransformation { factor, offset }) = found else {
        return Ok(Linear::NONE);
    };
    let (factor, offset) = (
        factor.unwrap_or_else(|| "1".into()),
        offset.unwrap_or_else(|| "0".into()),
    );
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    match (number(&factor), number(&offset)) {
        (Some(factor), Some(offset)) => Ok(Linear { factor, offset }),
        _ => bail!(
            "LinearTransformation with factor {factor} and offset {offset}; both must be finite"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPOSITORY: &str = include_str!("../../../system/SystemStructure.ssd");

    fn small(connections: &str) -> String {
        format!(
            r#"<ssd:SystemStructureDescription xmlns:ssd="urn:ssd" xmlns:ssc="urn:ssc" xmlns:ssv="urn:ssv" version="1.0" name="s">
            <ssd:System name="s"><ssd:Elements>
              <ssd:Component name="a" source="resources/A.fmu"><ssd:Connectors>
                <ssd:Connector name="y" kind="output"><ssc:Real unit="N"/></ssd:Connector>
                <ssd:Connector name="z" kind="output"><ssc:Real unit="m"/></ssd:Connector></ssd:Connectors>
                <ssd:ParameterBindings><ssd:ParameterBinding prefix="p."><ssd:ParameterValues>
                  <ssv:ParameterSet version="1.0" name="x"><ssv:Parameters>
                    <ssv:Parameter name="k"><ssv:Real value="2.5"/></ssv:Parameter>
                    <ssv:Parameter name="n"><ssv:Integer value="3"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>
                </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings></ssd:Component>
              <ssd:Component name="b" source="resources/B.fmu"><ssd:Connectors>
                <ssd:Connector name="u" kind="input"><ssc:Real unit="N"/></ssd:Connector></ssd:Connectors></ssd:Component>
            </ssd:Elements><ssd:Connections>{connections}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"#
        )
    }

    fn link(a: &str, y: &str, b: &str, u: &str) -> String {
        format!(
            r#"<ssd:Connection startElement="{a}" startConnector="{y}" endElement="{b}" endConnector="{u}"/>"#
        )
    }

    #[test]
    fn the_repository_system_is_read_whole() {
        let s = Structure::parse(REPOSITORY).unwrap();
        let names: Vec<_> = s.components.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["controller", "emla_1", "emla_2", "emla_3", "hdrm"]);
        // 3 actuators × (3 motion + 1 force + 4 measurements + 2 voltages) + 12 joint + 3 rod measurements + 3 torques
        assert_eq!(s.connections.len(), 3 * 10 + 12 + 3 + 3);
        let bonds: Vec<_> = s
            .connections
            .iter()
            .filter(|c| c.bond.is_some())
            .map(ToString::to_string)
            .collect();
        assert_eq!(
            bonds,
            [
                "emla_1.F -> hdrm.f[1]",
                "emla_2.F -> hdrm.f[2]",
                "emla_3.F -> hdrm.f[3]"
            ]
        );
        let bond = PowerBond {
            step_mean: "F_mean".into(),
            flow: "x_dot".into(),
            power: Power::Delivered,
        };
        assert!(
            s.connections
                .iter()
                .filter_map(|c| c.bond.as_ref())
                .all(|b| *b == bond)
        );
        assert_eq!((s.start_time, s.stop_time), (0.0, Some(24.25)));
    }

    #[test]
    fn parameter_values_carry_their_prefix() {
        let s = Structure::parse(&small("")).unwrap();
        assert_eq!(values(&s.components[0]), ["p.k=2.5", "p.n=3"]);
    }

    fn values(c: &Component) -> Vec<String> {
        c.parameters
            .iter()
            .map(|p| format!("{}={}", p.name, p.value))
            .collect()
    }

    /// A set bound to a component names its variables, one bound to the system component and variable; the latter has the last word.
    #[test]
    fn sets_in_files_are_bound_to_components_and_to_the_system() {
        let bind = |source: &str| {
            format!(
                r#"<ssd:ParameterBindings><ssd:ParameterBinding source="{source}"/></ssd:ParameterBindings>"#
            )
        };
        let set = |name: &str, value: &str| {
            format!(
                r#"<ParameterSet><Parameters><Parameter name="{name}"><Real value="{value}"/></Parameter></Parameters></ParameterSet>"#
            )
        };
        let text = small("")
            .replace(
                "</ssd:Connectors></ssd:Component>", // of b; a has bindings in between
                &format!("</ssd:Connectors>{}</ssd:Component>", bind("b.ssv")),
            )
            .replace(
                "<ssd:Elements>",
                &format!("{}<ssd:Elements>", bind("all.ssv")),
            );
        let s = Structure::read(&text, |source| {
            Ok(match source {
                "b.ssv" => set("u.0", "1"),
                _ => set("b.u.0", "2"),
            })
        })
        .unwrap();
        assert_eq!(values(&s.components[1]), ["u.0=1", "u.0=2"]);
        assert_eq!(
            s.components[1].parameters[1].origin,
            "parameter set `all.ssv`"
        );

        let error = |found: Result<String>| {
            let mut found = Some(found);
            let read = Structure::read(&text, |_| found.take().unwrap());
            format!("{:#}", read.unwrap_err())
        };
        let missing = error(Err(anyhow::anyhow!("no such file")));
        assert!(
            missing.contains("component `b`") && missing.contains("no such file"),
            "{missing}"
        );
        let foreign = Structure::read(&text, |_| Ok(set("c.u", "1"))).unwrap_err();
        assert!(
            foreign.to_string().contains("`c.u` is not a variable"),
            "{foreign}"
        );
        assert!(Structure::parse(&text).is_err());
    }

    #[test]
    fn wrong_connections_are_named() {
        for (connections, expected) in [
            (link("a", "y", "c", "u"), "component `c`"),
            (link("a", "q", "b", "u"), "no connector `q`"),
            (link("b", "u", "b", "u"), "declared as input"),
            (link("a", "z", "b", "u"), "units differ, m and N"),
            (
                link("a", "y", "b", "u") + &link("a", "y", "b", "u"),
                "driven twice",
            ),
        ] {
            let error = Structure::parse(&small(&connections))
                .unwrap_err()
                .to_string();
            assert!(error.contains(expected), "{error}");
        }
        assert!(Structure::parse("<a/>").is_err());
        assert!(Structure::parse("no xml").is_err());
    }
}
