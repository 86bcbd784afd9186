//! The flat system that `flatten` makes and the master runs: FMU components, the connections
//! between them and their start values, without nested systems.

use std::collections::HashMap;

use fmi_description::{Interface, Unit};
use fmi_import::Limits;
use system_structure::{Connector, DataType, Direction, MappingEntry, Transformation};

use super::alarm::Alarm;
use super::bond::PowerBond;

/// One FMU instance of the system. The Gauss–Seidel schedule steps components in file order.
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
    /// Replace all values bound to a variable by one; `origin` says where it comes from, for
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
    /// Type of the value.
    pub data_type: DataType,
    /// Unit of a real value.
    pub unit: Option<Unit>,
    /// Transformations of the value before it reaches the variable.
    pub way: Vec<Hop>,
    /// Where the value comes from, for messages.
    pub origin: String,
}

/// One of the connections that a value passes: more than one where it leads through connectors of
/// nested systems.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hop {
    /// Transformation of the value.
    pub transformation: Option<Transformation>,
    /// Units are not converted (`suppressUnitConversion`).
    pub keeps_units: bool,
    /// Unit declared at its end.
    pub unit: Option<Unit>,
}

impl From<&MappingEntry> for Hop {
    fn from(entry: &MappingEntry) -> Self {
        Self {
            transformation: entry.transformation.clone(),
            keeps_units: entry.keeps_units,
            unit: None,
        }
    }
}

/// A connection from an output to an input.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Connection {
    /// Component and output.
    pub start: (String, String),
    /// Component and input.
    pub end: (String, String),
    /// Unit declared at the start.
    pub unit: Option<Unit>,
    /// Transformations of the values, in order.
    pub way: Vec<Hop>,
    /// Between parameters: passed in initialization only.
    pub is_initial: bool,
    /// Power bond whose effort the connection carries.
    pub bond: Option<PowerBond>,
    /// The input is the sum of all its connections, which say so all.
    pub is_term: bool,
    /// File and line, for messages; empty for a connection made by the program.
    pub place: String,
}

impl std::fmt::Display for Connection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ((a, y), (b, u)) = (&self.start, &self.end);
        write!(f, "{a}.{y} -> {b}.{u}")
    }
}

/// An input of the outermost system, which feeds inputs of components.
#[derive(Clone, Debug, PartialEq)]
pub struct OuterInput {
    /// Name.
    pub name: String,
    /// Declared unit.
    pub unit: Option<Unit>,
    /// Component and input, with the transformations on the way there.
    pub ends: Vec<((String, String), Vec<Hop>)>,
}

/// An output of the outermost system, which shows the output of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct OuterOutput {
    /// Name.
    pub name: String,
    /// Component and output.
    pub start: (String, String),
}

/// Options that say how components use their FMUs.
#[derive(Clone, Debug, Default)]
pub struct FmuUse {
    /// Interfaces: `a=me`, `wheel_*=cs`, or `me` if there is one component.
    pub interfaces: Vec<String>,
    /// Components in processes of their own: `a`, `wheel_*`, or `all`.
    pub isolated: Vec<String>,
    /// Limits of these processes.
    pub limits: Limits,
    /// FMUs that have both run as WebAssembly, not by their libraries.
    pub prefers_wasm: bool,
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
    /// The structure itself declares the start time.
    pub has_start: bool,
    /// Stop time of the default experiment, s.
    pub stop_time: Option<f64>,
    /// Communication step that the structure requests, s.
    pub step: Option<f64>,
    /// Components without declared dependencies whose outputs may nevertheless be read again after
    /// inputs were set.
    pub feedthrough: Vec<String>,
    /// Components with communication steps of their own, s; the last entry of a component counts.
    pub rates: Vec<(String, f64)>,
    /// Components that use this interface of their FMU; of two entries the last counts.
    pub interfaces: Vec<(String, Interface)>,
    /// Components that live in processes of their own.
    pub isolated: Vec<String>,
    /// Limits of these processes.
    pub limits: Limits,
    /// FMUs that have both run as WebAssembly, not by their libraries.
    pub prefers_wasm: bool,
    /// Outputs that mean that the result is not good.
    pub alarms: Vec<Alarm>,
    /// Algebraic loops are solved instead of refused.
    pub solves_loops: bool,
    /// Changes to the structure as its file has it, for the user.
    pub remarks: Vec<String>,
    /// Parameter values that match no variable, with their origin; the standard has them ignored.
    pub unmatched: Vec<String>,
}

impl Structure {
    /// Component and variable of a name `component.variable`. Names of components may contain dots:
    /// the longest matching one counts.
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

    /// Connect an output to an input that no connection drives yet. Missing connectors are added.
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
                    mime_type: None,
                    dimensions: Vec::new(),
                    line: 0,
                });
            }
        }
        self.connections.push(Connection {
            start,
            end,
            way: vec![Hop::default()],
            ..Connection::default()
        });
    }

    /// Let the input `name` of the system feed an input of a component; `places` has the places of
    /// the inputs by name.
    pub(super) fn feed(
        &mut self,
        places: &mut HashMap<String, usize>,
        name: String,
        unit: Option<Unit>,
        end: ((String, String), Vec<Hop>),
    ) {
        let place = *places.entry(name.clone()).or_insert(self.inputs.len());
        if place == self.inputs.len() {
            let ends = Vec::new();
            self.inputs.push(OuterInput { name, unit, ends });
        }
        self.inputs[place].ends.push(end);
    }
}
