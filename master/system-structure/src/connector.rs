//! Connectors of elements and systems: what is declared of a variable.

use crate::common::{DataType, Unit};
use crate::error::StructureError;
use crate::xml::Node;

/// Which way values go through a connector, `kind`.
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
    /// Either, as its connections need it (inout, unspecified).
    Either,
}

impl Direction {
    /// As the file writes it.
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

/// A variable of an element that is declared.
#[derive(Clone, Debug, PartialEq)]
pub struct Connector {
    /// Name.
    pub name: String,
    /// Which way values go.
    pub direction: Direction,
    /// Type, where one is declared.
    pub data_type: Option<DataType>,
    /// Unit of a real connector, where one is declared.
    pub unit: Option<Unit>,
    /// Enumeration that it names.
    pub enumeration: Option<String>,
    /// Lengths of an array, None where another connector or the component says it; empty for a
    /// scalar (SSP 2.0).
    pub dimensions: Vec<Option<usize>>,
    /// Line of the file.
    pub line: usize,
}

pub(crate) fn connectors(node: &Node, units: &[Unit]) -> Result<Vec<Connector>, StructureError> {
    let read = |c: &Node| {
        let name = c.required("name")?;
        let direction = match c.required("kind")? {
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
        let attribute = |name| declared.and_then(|(_, node)| node.attribute(name));
        let is_enumeration = declared.is_some_and(|(t, _)| t == DataType::Enumeration);
        let dimensions = c.children.iter().filter(|d| d.name == "Dimension");
        let size = |d: &Node| {
            let Some(text) = d.attribute("size") else {
                return Ok(None);
            };
            let unfit = || format!("connector `{name}` has a dimension of the size `{text}`");
            let size = text.trim().parse();
            size.map(Some).map_err(|_| d.error(unfit()))
        };
        Ok(Connector {
            dimensions: dimensions.map(size).collect::<Result<_, _>>()?,
            name: name.to_string(),
            direction,
            data_type: declared.map(|(data_type, _)| data_type),
            unit: attribute("unit").map(|name| Unit::of(units, name)),
            enumeration: attribute("name")
                .filter(|_| is_enumeration)
                .map(str::to_string),
            line: c.line,
        })
    };
    node.listed("Connectors", "Connector").map(read).collect()
}
