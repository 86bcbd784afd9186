//! What the model description promises: the variables with their bounds, the log categories, the capabilities.

use anyhow::{Context, Result, anyhow};
use serde::Deserialize;

/// Type of a variable; an enumeration is an Integer from 1 to its number of items.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// fmi2Real.
    Real,
    /// fmi2Integer, or an enumeration.
    Integer,
    /// fmi2Boolean.
    Boolean,
    /// fmi2String.
    String,
}

/// A scalar variable.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Name.
    pub name: String,
    /// Value reference.
    pub reference: u32,
    /// Type.
    pub kind: Kind,
    /// `input`, `output`, `parameter` or `local`.
    pub causality: String,
    /// `continuous`, `discrete`, `fixed`, `tunable` or `constant`.
    pub variability: String,
    /// Least and greatest value allowed.
    pub bounds: [f64; 2],
    /// Start value of a number.
    pub start: f64,
}

impl Variable {
    /// An input of any type.
    pub fn is_input(&self) -> bool {
        self.causality == "input"
    }

    /// An output, or a local variable.
    pub fn is_computed(&self) -> bool {
        matches!(self.causality.as_str(), "output" | "local")
    }

    /// A parameter that may be set between steps.
    pub fn is_tunable(&self) -> bool {
        self.causality == "parameter" && self.variability == "tunable"
    }
}

/// The parts of a model description that calls depend on.
#[derive(Clone, Debug)]
pub struct Description {
    /// File stem of the library.
    pub identifier: String,
    /// GUID as written.
    pub guid: String,
    /// Declared log categories.
    pub categories: Vec<String>,
    /// providesDirectionalDerivative.
    pub directional_derivatives: bool,
    /// maxOutputDerivativeOrder > 0.
    pub output_derivatives: bool,
    /// All variables.
    pub variables: Vec<Variable>,
}

impl Description {
    /// Reads the text of a modelDescription.xml.
    pub fn parse(text: &str) -> Result<Self> {
        let file: xml::File = quick_xml::de::from_str(text).context("modelDescription.xml")?;
        let types = file.types.types;
        let variables = file.variables.variables.into_iter();
        let variables = variables
            .map(|v| variable(v, &types))
            .collect::<Result<_>>()?;
        Ok(Self {
            identifier: file.co_simulation.identifier,
            guid: file.guid,
            categories: file
                .categories
                .categories
                .into_iter()
                .map(|c| c.name)
                .collect(),
            directional_derivatives: file.co_simulation.directional_derivatives,
            output_derivatives: file.co_simulation.output_derivatives > 0,
            variables,
        })
    }

    /// The variable with this value reference.
    pub fn find(&self, reference: u32) -> Option<&Variable> {
        self.variables.iter().find(|v| v.reference == reference)
    }
}

fn variable(v: xml::Variable, types: &[xml::SimpleType]) -> Result<Variable> {
    let (kind, typed) = match (v.real, v.integer, v.boolean, v.string, v.enumeration) {
        (Some(t), ..) => (Kind::Real, t),
        (_, Some(t), ..) => (Kind::Integer, t),
        (_, _, Some(t), ..) => (Kind::Boolean, t),
        (_, _, _, Some(t), _) => (Kind::String, t),
        (.., Some(t)) => (Kind::Integer, t),
        _ => return Err(anyhow!("variable `{}` has no type", v.name)),
    };
    let declared = types
        .iter()
        .find(|t| Some(&t.name) == typed.declared_type.as_ref());
    let items = declared.and_then(|t| t.enumeration.as_ref());
    let (first, last) = items.map_or((f64::NEG_INFINITY, f64::INFINITY), |e| {
        (1.0, e.items.len() as f64)
    });
    let start = typed.start.as_deref().and_then(|s| s.parse().ok());
    Ok(Variable {
        name: v.name,
        reference: v.reference,
        kind,
        causality: v.causality.unwrap_or_else(|| "local".into()),
        variability: v.variability.unwrap_or_else(|| "continuous".into()),
        bounds: [typed.min.unwrap_or(first), typed.max.unwrap_or(last)],
        start: start.unwrap_or(0.0),
    })
}

/// The elements of the file; only what is read.
mod xml {
    use super::Deserialize;

    #[derive(Deserialize)]
    pub struct File {
        #[serde(rename = "@guid")]
        pub guid: String,
        #[serde(rename = "CoSimulation")]
        pub co_simulation: CoSimulation,
        #[serde(rename = "LogCategories", default)]
        pub categories: Categories,
        #[serde(rename = "TypeDefinitions", default)]
        pub types: Types,
        #[serde(rename = "ModelVariables")]
        pub variables: Variables,
    }
    #[derive(Deserialize)]
    pub struct CoSimulation {
        #[serde(rename = "@modelIdentifier")]
        pub identifier: String,
        #[serde(rename = "@providesDirectionalDerivative", default)]
        pub directional_derivatives: bool,
        #[serde(rename = "@maxOutputDerivativeOrder", default)]
        pub output_derivatives: u32,
    }
    #[derive(Default, Deserialize)]
    pub struct Categories {
        #[serde(rename = "Category", default)]
        pub categories: Vec<Category>,
    }
    #[derive(Deserialize)]
    pub struct Category {
        #[serde(rename = "@name")]
        pub name: String,
    }
    #[derive(Default, Deserialize)]
    pub struct Types {
        #[serde(rename = "SimpleType", default)]
        pub types: Vec<SimpleType>,
    }
    #[derive(Deserialize)]
    pub struct SimpleType {
        #[serde(rename = "@name")]
        pub name: String,
        #[serde(rename = "Enumeration")]
        pub enumeration: Option<Enumeration>,
    }
    #[derive(Deserialize)]
    pub struct Enumeration {
        #[serde(rename = "Item", default)]
        pub items: Vec<Category>,
    }
    #[derive(Deserialize)]
    pub struct Variables {
        #[serde(rename = "ScalarVariable", default)]
        pub variables: Vec<Variable>,
    }
    #[derive(Deserialize)]
    pub struct Variable {
        #[serde(rename = "@name")]
        pub name: String,
        #[serde(rename = "@valueReference")]
        pub reference: u32,
        #[serde(rename = "@causality")]
        pub causality: Option<String>,
        #[serde(rename = "@variability")]
        pub variability: Option<String>,
        #[serde(rename = "Real")]
        pub real: Option<Typed>,
        #[serde(rename = "Integer")]
        pub integer: Option<Typed>,
        #[serde(rename = "Boolean")]
        pub boolean: Option<Typed>,
        #[serde(rename = "String")]
        pub string: Option<Typed>,
        #[serde(rename = "Enumeration")]
        pub enumeration: Option<Typed>,
    }
    #[derive(Deserialize)]
    pub struct Typed {
        #[serde(rename = "@declaredType")]
        pub declared_type: Option<String>,
        #[serde(rename = "@min")]
        pub min: Option<f64>,
        #[serde(rename = "@max")]
        pub max: Option<f64>,
        #[serde(rename = "@start")]
        pub start: Option<String>,
    }
}
