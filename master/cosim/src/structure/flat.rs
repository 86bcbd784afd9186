//! A system without systems in it: components and the connections between them, as the master runs
//! them.

use fmi_description::Unit;
use system_structure::{Connector, DataType, Direction, Transformation};

use super::bond::PowerBond;

/// One FMU instance of the system; the order in the file is the stepping order of the Gauss–Seidel
/// schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Name of the instance; in a nested system its path, `system.component`.
    pub name: String,
    /// FMU file relative to the system structure, for example `resources/Emla.fmu`.
    pub source: String,
    /// Declared inputs, outputs and parameters.
    pub connectors: Vec<Connector>,
    /// Start values from the parameter bindings, applied in this order.
    pub parameters: Vec<Parameter>,
}

impl Component {
    /// Give a variable a value in place of all that it is bound to; `origin` says who does, for
    /// messages.
    pub fn bind(&mut self, name: &str, value: String, data_type: DataType, origin: &str) {
        self.parameters.retain(|p| p.name != name);
        self.parameters.push(Parameter {
            name: name.into(),
            value,
            data_type,
            unit: None,
            way: Vec::new(),
            origin: origin.into(),
        });
    }
}

/// Start value of a variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name of the variable; in a set for a whole system `component.variable`.
    pub name: String,
    /// Value.
    pub value: String,
    /// Type in which it is given.
    pub data_type: DataType,
    /// Unit of a real value.
    pub unit: Option<Unit>,
    /// What becomes of the value before it reaches the variable.
    pub way: Vec<Hop>,
    /// Where the value stands, for messages.
    pub origin: String,
}

/// One connection on the way of a value, which may lead through connectors of systems.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hop {
    /// What becomes of the value.
    pub transformation: Option<Transformation>,
    /// The units of both ends may differ, because the numbers are meant as the transformation
    /// leaves them.
    pub keeps_units: bool,
    /// Unit that is declared at its end.
    pub unit: Option<Unit>,
}

/// A connection from an output to an input.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// Component and output.
    pub start: (String, String),
    /// Component and input.
    pub end: (String, String),
    /// Unit that is declared at the start.
    pub unit: Option<Unit>,
    /// What becomes of a value on its way.
    pub way: Vec<Hop>,
    /// Of a parameter: passed in initialization only.
    pub is_initial: bool,
    /// Set where the connection carries the effort of a power bond.
    pub bond: Option<PowerBond>,
    /// File and line, for messages; empty where no file has it.
    pub place: String,
}

impl std::fmt::Display for Connection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ((a, y), (b, u)) = (&self.start, &self.end);
        write!(f, "{a}.{y} -> {b}.{u}")
    }
}

/// A connector of the outermost system that gives its value to inputs of components.
#[derive(Clone, Debug, PartialEq)]
pub struct OuterInput {
    /// Name.
    pub name: String,
    /// Unit that is declared.
    pub unit: Option<Unit>,
    /// Component, input, and what becomes of a value on its way there.
    pub ends: Vec<((String, String), Vec<Hop>)>,
}

/// A connector of the outermost system that shows the output of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct OuterOutput {
    /// Name.
    pub name: String,
    /// Component and output.
    pub start: (String, String),
}

/// A system: components, connections and the default experiment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Structure {
    /// Name of the system.
    pub name: String,
    /// Components in stepping order.
    pub components: Vec<Component>,
    /// Connections in file order.
    pub connections: Vec<Connection>,
    /// Inputs of the outermost system.
    pub inputs: Vec<OuterInput>,
    /// Outputs of the outermost system.
    pub outputs: Vec<OuterOutput>,
    /// Start time of the default experiment, s (0 when absent).
    pub start_time: f64,
    /// Stop time of the default experiment, s.
    pub stop_time: Option<f64>,
    /// Communication step that the structure asks for, s.
    pub step: Option<f64>,
    /// Components whose outputs may be read again after inputs were set although they declare no
    /// dependencies.
    pub feedthrough: Vec<String>,
    /// Components with steps of their own, s; the last of several counts.
    pub rates: Vec<(String, f64)>,
    /// Declared algebraic loops are solved.
    pub solves_loops: bool,
    /// What was made of it that its file does not say.
    pub remarks: Vec<String>,
    /// Parameter values that match nothing, with their origin: by the standard they are passed
    /// over.
    pub unmatched: Vec<String>,
}

impl Structure {
    /// Component and variable of a name `component.variable`; names of components may hold dots.
    pub fn split<'a>(&self, name: &'a str) -> Option<(usize, &'a str)> {
        let fits = |(k, c): (usize, &Component)| {
            let variable = name.strip_prefix(&c.name)?.strip_prefix('.')?;
            Some((k, variable))
        };
        let all = self.components.iter().enumerate().filter_map(fits);
        all.min_by_key(|(_, variable)| variable.len())
    }

    /// Index of the component named `name`.
    pub fn component(&self, name: &str) -> Option<usize> {
        self.components.iter().position(|c| c.name == name)
    }

    /// Names of all components, for messages.
    pub fn component_names(&self) -> String {
        let names: Vec<_> = self.components.iter().map(|c| c.name.as_str()).collect();
        names.join(", ")
    }

    /// Connect an output with an input that no connection drives yet; both get connectors where
    /// they have none.
    pub fn connect(&mut self, start: (String, String), end: (String, String)) {
        for ((component, name), direction) in
            [(&start, Direction::Output), (&end, Direction::Input)]
        {
            let mut components = self.components.iter_mut();
            if let Some(component) = components.find(|c| c.name == *component)
                && component.connectors.iter().all(|c| c.name != *name)
            {
                component.connectors.push(Connector {
                    name: name.clone(),
                    direction,
                    data_type: None,
                    unit: None,
                    dimensions: Vec::new(),
                    line: 0,
                });
            }
        }
        self.connections.push(Connection {
            start,
            end,
            unit: None,
            way: vec![Hop::default()],
            is_initial: false,
            bond: None,
            place: String::new(),
        });
    }
}
