//! What a `modelDescription.xml` of FMI 2.0 or 3.0 (co-simulation) says, typed: identity, capabilities, variables with their types and
//! bounds, and which inputs each output depends on. Where a notion is the same in both versions, so is its type here.
//!
//! References to sections are to the specifications of FMI 2.0.4 and 3.0.1. Attributes that are left out have the value that the
//! specification gives them there, and what a variable leaves to its declared type is filled in. An array of FMI 3.0 is one variable;
//! [`Description::by_element`] has a variable for each of its elements, as FMI 2.0 would.
//!
//! ```
//! let text = r#"<fmiModelDescription fmiVersion="2.0" modelName="Lag" guid="{1}">
//!   <CoSimulation modelIdentifier="Lag"/>
//!   <ModelVariables><ScalarVariable name="u" valueReference="0" causality="input"><Real unit="m" start="1"/></ScalarVariable></ModelVariables>
//!   <ModelStructure/>
//! </fmiModelDescription>"#;
//! let description = fmu_description::Description::parse(text).unwrap();
//! let u = description.variable("u").unwrap();
//! assert_eq!((u.unit.as_deref(), u.start_number()), (Some("m"), Some(1.0)));
//! ```
#![forbid(unsafe_code)]

mod elements;
mod error;
mod fmi2;
mod fmi3;
mod structure;
mod terminals;
mod variable;
mod xml;

use std::collections::HashMap;

use serde::Deserialize;

pub use error::DescriptionError;
pub use structure::Unknown;
pub use terminals::{Member, Terminal, terminals};
pub use variable::{Access, Causality, Initial, Item, Kind, Variability, Variable};

/// A version of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Version {
    /// 2.0.
    Fmi2,
    /// 3.0, and minor versions of it.
    Fmi3,
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
    /// Identifier that the FMU and its importer must agree on: `guid` of FMI 2.0, `instantiationToken` of FMI 3.0.
    pub guid: String,
    /// Version of the model, empty where none is given.
    pub version: String,
    /// Program that generated the FMU, empty where none is given.
    pub tool: String,
    /// Name of the shared library without its suffix, a C identifier.
    pub identifier: String,
    /// What the FMU can do as a co-simulation slave.
    pub capabilities: Capabilities,
    /// Names of the log categories.
    pub log_categories: Vec<String>,
    /// Units of the variables.
    pub units: Vec<Unit>,
    /// How a simulation is set up if the user says nothing else.
    pub default_experiment: DefaultExperiment,
    /// Variables in the order of the file, which is how [`Unknown`] counts them.
    pub variables: Vec<Variable>,
    /// Outputs with their dependencies at a communication point.
    pub outputs: Vec<Unknown>,
    /// Variables that are computed in Initialization Mode, with their dependencies there.
    pub initial_unknowns: Vec<Unknown>,
    by_name: HashMap<String, usize>,
}

/// Capability flags of co-simulation (FMI 2.0, section 4.3.1; FMI 3.0, section 4.4.1); what is not named, or not known to the version, is
/// false or 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
}

/// A unit with its conversion to SI base units: value in base units = `factor` · value + `offset` (FMI 2.0, section 2.2.2).
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// Name.
    pub name: String,
    /// Exponents of kg, m, s, A, K, mol, cd and rad; None where the description names no base unit.
    pub exponents: Option<[i32; 8]>,
    /// Factor to base units.
    pub factor: f64,
    /// Offset in base units.
    pub offset: f64,
}

/// `DefaultExperiment`; times in s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
pub struct DefaultExperiment {
    /// First time.
    #[serde(rename = "@startTime")]
    pub start: Option<f64>,
    /// Last time.
    #[serde(rename = "@stopTime")]
    pub stop: Option<f64>,
    /// Relative tolerance.
    #[serde(rename = "@tolerance")]
    pub tolerance: Option<f64>,
    /// Communication step.
    #[serde(rename = "@stepSize")]
    pub step: Option<f64>,
}

impl Description {
    /// Read the text of a `modelDescription.xml`.
    pub fn parse(text: &str) -> Result<Self, DescriptionError> {
        xml::read(text)
    }

    fn index_names(&mut self) {
        let names = self.variables.iter().enumerate();
        self.by_name = names.map(|(k, v)| (v.name.clone(), k)).collect();
    }

    /// Index of the variable named `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
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
