//! Connectors of components, systems and signal dictionaries: the declared name, direction, type,
//! unit and size of a variable, for `cosim`. Parameter sets share the types and units.

use std::collections::HashMap;

use fmi_description::Unit;
use fmi_description::xml::{Element, XmlError};

/// The units that a file defines, by name.
pub(crate) struct Units(HashMap<String, Unit>);

impl Units {
    pub(crate) fn read(file: &Element) -> Result<Self, XmlError> {
        let mut units = HashMap::new();
        for unit in file.listed("Units", "Unit").map(Unit::read) {
            let unit = unit?;
            units.entry(unit.name.clone()).or_insert(unit);
        }
        Ok(Self(units))
    }

    /// The unit of an element with a type; None if it has none, or an empty one.
    pub(crate) fn of(&self, typed: &Element) -> Option<Unit> {
        let name = Unit::name_in(typed, "unit")?;
        let defined = self.0.get(name).cloned();
        Some(defined.unwrap_or_else(|| Unit::named(name)))
    }
}

/// Type of a connector or a parameter. The bit widths of FMI 3.0 are not distinguished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// Real, Float64, Float32.
    Real,
    /// Integer, and Int8 to UInt64.
    Integer,
    /// Boolean.
    Boolean,
    /// String.
    String,
    /// Enumeration.
    Enumeration,
    /// Binary.
    Binary,
    /// Clock.
    Clock,
}

impl DataType {
    /// Name in SSP 1.0.
    pub fn name(self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer",
            Self::Boolean => "Boolean",
            Self::String => "String",
            Self::Enumeration => "Enumeration",
            Self::Binary => "Binary",
            Self::Clock => "Clock",
        }
    }

    /// Type of this name in SSP or FMI.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "Real" | "Float64" | "Float32" => Self::Real,
            "Integer" | "Int8" | "UInt8" | "Int16" | "UInt16" | "Int32" | "UInt32" | "Int64"
            | "UInt64" => Self::Integer,
            "Boolean" => Self::Boolean,
            "String" => Self::String,
            "Enumeration" => Self::Enumeration,
            "Binary" => Self::Binary,
            "Clock" => Self::Clock,
            _ => return None,
        })
    }

    /// The type that `node` declares, and the element that declares it.
    pub(crate) fn declared(node: &Element) -> Option<(Self, &Element)> {
        let mut children = node.children.iter();
        children.find_map(|c| Some((Self::from_name(&c.tag)?, c)))
    }
}

/// Direction of the values through a connector, attribute `kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Into the element.
    Input,
    /// Out of the element.
    Output,
    /// Into the element, before the run.
    Parameter,
    /// Out of the element, known after initialization.
    CalculatedParameter,
    /// Either way, as the connections require (inout, unspecified).
    Either,
}

impl Direction {
    /// Name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Output => "output",
            Self::Parameter => "parameter",
            Self::CalculatedParameter => "calculatedParameter",
            Self::Either => "inout",
        }
    }
}

/// A declared variable of a component or a system.
#[derive(Clone, Debug, PartialEq)]
pub struct Connector {
    /// Name.
    pub name: String,
    /// Direction of the values.
    pub direction: Direction,
    /// Type, where one is declared.
    pub data_type: Option<DataType>,
    /// Unit of a real connector, where one is declared.
    pub unit: Option<Unit>,
    /// What the bytes of a Binary are, where that is declared (SSP 2.0).
    pub mime_type: Option<String>,
    /// Sizes of an array (SSP 2.0), None where the file leaves one to the FMU; empty for a scalar.
    pub dimensions: Vec<Option<usize>>,
    /// Line in the file, for messages.
    pub line: usize,
}

/// The connectors that the element `node` declares.
pub(crate) fn read_connectors(node: &Element, units: &Units) -> Result<Vec<Connector>, XmlError> {
    let read = |c: &Element| {
        let name = c.required("name")?;
        let direction = match c.required("kind")?.as_str() {
            "input" => Direction::Input,
            "output" | "local" => Direction::Output,
            "parameter" | "structuralParameter" => Direction::Parameter,
            "calculatedParameter" | "constant" => Direction::CalculatedParameter,
            "inout" | "unspecified" => Direction::Either,
            other => {
                return Err(c.error(format!(
                    "connector `{name}` is of the unknown kind `{other}`"
                )));
            }
        };
        let declared = DataType::declared(c);
        let dimensions = c.all("Dimension");
        let size = |d: &Element| {
            let Some(text) = d.get("size") else {
                return Ok(None);
            };
            let unfit = || format!("connector `{name}` has a dimension of the size `{text}`");
            let size = text.trim().parse();
            size.map(Some).map_err(|_| d.error(unfit()))
        };
        Ok(Connector {
            dimensions: dimensions.map(size).collect::<Result<_, _>>()?,
            name,
            direction,
            data_type: declared.map(|(data_type, _)| data_type),
            unit: declared.and_then(|(_, node)| units.of(node)),
            mime_type: declared.and_then(|(_, node)| node.get("mime-type").map(str::to_string)),
            line: c.line,
        })
    };
    node.listed("Connectors", "Connector").map(read).collect()
}
