//! Connectors of elements and systems: what is declared of a variable.

use fmi_description::Unit;
use fmi_description::xml::{Element, XmlError};

use crate::common::DataType;

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
    /// Lengths of an array, None where another connector or the component says it; empty for a
    /// scalar (SSP 2.0).
    pub dimensions: Vec<Option<usize>>,
    /// Line of the file.
    pub line: usize,
}

pub(crate) fn connectors(node: &Element, units: &[Unit]) -> Result<Vec<Connector>, XmlError> {
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
        let unit = declared.and_then(|(_, node)| node.get("unit"));
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
            unit: unit.map(|name| Unit::find_or_named(units, name)),
            line: c.line,
        })
    };
    node.listed("Connectors", "Connector").map(read).collect()
}
