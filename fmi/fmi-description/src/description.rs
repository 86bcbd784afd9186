//! [`Description`]: a whole model description, with identity, capabilities, units, variables and
//! their dependencies. `parse` makes it for importer, master, check, `torture` and `cargo fmu`.

use std::collections::HashMap;
use std::sync::Arc;

use crate::error::DescriptionError;
use crate::remark::Remark;
use crate::unit::Unit;
use crate::variable::{Kind, Variability, Variable};

/// A version of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Version {
    /// 2.0.
    Fmi2,
    /// 3.0, and minor versions of it.
    Fmi3,
}

/// An interface of an FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Interface {
    /// The FMU steps itself.
    CoSimulation,
    /// The importer integrates the model's states.
    ModelExchange,
    /// The importer activates partitions of the model.
    ScheduledExecution,
}

impl std::fmt::Display for Version {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Fmi2 => "2.0",
            Self::Fmi3 => "3.0",
        })
    }
}

/// A model description.
#[derive(Clone, Debug)]
pub struct Description {
    /// Version of FMI.
    pub fmi: Version,
    /// Name of the model.
    pub model: String,
    /// Identifier that the FMU and its importer must agree on: `guid` of FMI 2.0,
    /// `instantiationToken` of FMI 3.0.
    pub guid: String,
    /// Version of the model, empty where none is given.
    pub version: String,
    /// Program that generated the FMU, empty where none is given.
    pub tool: String,
    /// Name of the shared library without its suffix; usually a C identifier, and always the name
    /// of a file.
    pub identifier: String,
    /// The interface whose identifier and capabilities these are.
    pub interface: Interface,
    /// Capabilities of this interface.
    pub capabilities: Capabilities,
    /// Names of the log categories.
    pub log_categories: Vec<String>,
    /// Units of the variables.
    pub units: Vec<Unit>,
    /// The experiment that the FMU proposes.
    pub default_experiment: DefaultExperiment,
    /// Variables in the order of the file, which is how [`Unknown`] counts them.
    pub variables: Vec<Variable>,
    /// Outputs with their dependencies at a communication point.
    pub outputs: Vec<Unknown>,
    /// Whether it offers Model Exchange, too.
    pub model_exchange: bool,
    /// The interfaces that it offers, in words.
    pub interfaces: Vec<&'static str>,
    /// Derivatives of the continuous states, in the order of the states, with their dependencies.
    pub derivatives: Vec<Unknown>,
    /// Number of event indicators.
    pub event_indicators: usize,
    /// Variables that are computed in Initialization Mode, with their dependencies there.
    pub initial_unknowns: Vec<Unknown>,
    /// Harmless violations of the standard.
    pub remarks: Vec<Remark>,
    pub(crate) index: Index,
}

/// Places of variables, units and entries of `ModelStructure`, so that nothing is searched for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Index {
    variables: HashMap<String, usize>,
    units: HashMap<String, usize>,
    outputs: HashMap<Place, usize>,
    initial_unknowns: HashMap<Place, usize>,
}

/// What an entry of `ModelStructure` is about: the number of a variable; in FMI 3.0, where aliases
/// share entries, a value reference and the place of an element.
type Place = (usize, Option<usize>);

/// A computed variable and what it depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Index into [`Description::variables`].
    pub variable: usize,
    /// Indices of the variables that it depends on. None if nothing is declared, which means all
    /// inputs. Elements of an array share them.
    pub dependencies: Option<Arc<[usize]>>,
}

/// Capability flags of an interface (FMI 2.0, sections 3.3.1 and 4.3.1; FMI 3.0, sections 3.3.1 and
/// 4.4.1). Flags that are left out, or that the version does not have, are false or 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Capabilities {
    /// `needsExecutionTool`.
    pub needs_execution_tool: bool,
    /// `canHandleVariableCommunicationStepSize`.
    pub variable_step: bool,
    /// `canInterpolateInputs`.
    pub interpolates_inputs: bool,
    /// `maxOutputDerivativeOrder`.
    pub output_derivative_order: u32,
    /// `canRunAsynchronuously`, spelt so by the standard.
    pub asynchronous: bool,
    /// `canBeInstantiatedOnlyOncePerProcess`.
    pub only_once: bool,
    /// `canNotUseMemoryManagementFunctions`.
    pub own_memory: bool,
    /// `canGetAndSetFMUstate`.
    pub saves_state: bool,
    /// `canSerializeFMUstate`.
    pub serializes_state: bool,
    /// `providesDirectionalDerivative`, in FMI 3.0 `providesDirectionalDerivatives`.
    pub directional_derivatives: bool,
    /// `providesAdjointDerivatives`.
    pub adjoint_derivatives: bool,
    /// `hasEventMode`.
    pub event_mode: bool,
    /// `providesIntermediateUpdate`.
    pub intermediate_update: bool,
    /// `canReturnEarlyAfterIntermediateUpdate`.
    pub returns_early: bool,
    /// `providesPerElementDependencies`.
    pub element_dependencies: bool,
    /// `needsCompletedIntegratorStep`, in FMI 2.0 not `completedIntegratorStepNotNeeded`; Model
    /// Exchange only.
    pub completes_steps: bool,
    /// `fixedInternalStepSize`, s: a communication step should be a multiple of it.
    pub internal_step: Option<f64>,
}

/// `DefaultExperiment`; times in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DefaultExperiment {
    /// First time.
    pub start: Option<f64>,
    /// Last time.
    pub stop: Option<f64>,
    /// Relative tolerance.
    pub tolerance: Option<f64>,
    /// Communication step.
    pub step: Option<f64>,
}

impl Description {
    /// Rebuilds the index.
    pub(crate) fn make_index(&mut self) {
        let entries = |list: &[Unknown]| {
            // Of two entries the first counts.
            let entries = list.iter().enumerate().rev();
            entries.map(|(k, u)| (self.place(u.variable), k)).collect()
        };
        let names = self.variables.iter().enumerate();
        let units = self.units.iter().enumerate().rev();
        self.index = Index {
            variables: names.map(|(k, v)| (v.name.clone(), k)).collect(),
            units: units.map(|(k, unit)| (unit.name.clone(), k)).collect(),
            outputs: entries(&self.outputs),
            initial_unknowns: entries(&self.initial_unknowns),
        };
    }

    fn place(&self, variable: usize) -> Place {
        let v = &self.variables[variable];
        match self.fmi {
            Version::Fmi2 => (variable, None),
            Version::Fmi3 => (v.reference as usize, v.element),
        }
    }

    /// The entry of `ModelStructure` on an output, at communication points.
    pub(crate) fn output(&self, variable: usize) -> Option<&Unknown> {
        let found = self.index.outputs.get(&self.place(variable));
        found.map(|k| &self.outputs[*k])
    }

    /// The same in Initialization Mode, on any variable.
    pub(crate) fn initial_unknown(&self, variable: usize) -> Option<&Unknown> {
        let found = self.index.initial_unknowns.get(&self.place(variable));
        found.map(|k| &self.initial_unknowns[*k])
    }

    /// Index of the variable named `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.index.variables.get(name).copied()
    }

    /// The unit `name`, or a unit with only the name if the description does not define it.
    pub fn unit(&self, name: &str) -> Unit {
        let found = self.index.units.get(name).map(|k| self.units[*k].clone());
        found.unwrap_or_else(|| Unit::named(name))
    }

    /// Whether a variable, or the array that it is an element of, is a continuous state of Model
    /// Exchange, that is, one of the [`derivatives`](Self::derivatives) is its derivative.
    pub fn is_state(&self, v: &Variable) -> bool {
        let derivatives = self.derivatives.iter();
        let states = derivatives.filter_map(|d| self.state_of(d.variable));
        let mut states = states.map(|k| &self.variables[k]);
        let place = |v: &Variable| (v.access(), v.reference);
        self.model_exchange && states.any(|state| place(state) == place(v))
    }

    /// Whether the FMU needs Event Mode: it has clocks, or inputs that change only at events.
    pub fn needs_events(&self) -> bool {
        let is_discrete = |v: &Variable| v.is_input() && v.variability == Variability::Discrete;
        let mut variables = self.variables.iter();
        variables.any(|v| v.kind == Kind::Clock || is_discrete(v))
    }

    /// The variable named `name`, or an error that suggests similar names.
    pub fn variable(&self, name: &str) -> Result<&Variable, DescriptionError> {
        let found = self.index(name).map(|k| &self.variables[k]);
        found.ok_or_else(|| self.unknown_variable(name))
    }

    fn unknown_variable(&self, name: &str) -> DescriptionError {
        let stem = name.split(['[', '.']).next().unwrap_or(name);
        let names = self.variables.iter().map(|v| v.name.as_str());
        let near: Vec<_> = names.filter(|v| v.starts_with(stem)).take(5).collect();
        let hint = match near.is_empty() {
            true => String::new(),
            false => format!(" (it has {})", near.join(", ")),
        };
        let (model, name) = (self.model.clone(), name.to_string());
        DescriptionError::UnknownVariable { model, name, hint }
    }
}
