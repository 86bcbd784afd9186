//! The elements of a file of FMI 3.0 as they stand, and how they become a [`Description`].

use std::collections::HashMap;

use serde::Deserialize;

use crate::xml::{File, check_identifier, required};
use crate::{
    Access, Capabilities, Causality, Description, DescriptionError, Initial, Item, Kind, Unknown,
    Variability, Variable, Version,
};

/// Read the text of a file.
pub fn read(text: &str) -> Result<Description, DescriptionError> {
    let file: File<CoSimulation, Types, Variables, Structure> = quick_xml::de::from_str(text)?;
    let guid = required(file.token, "@instantiationToken")?;
    let model = file.model_name;
    let Some(slave) = file.co_simulation else {
        return Err(DescriptionError::NoCoSimulation { model });
    };
    check_identifier(&model, &slave.identifier)?;
    let variables = variables(file.variables.variables, &file.types.types, &model)?;
    let references = References::new(&variables, &model);
    let [mut outputs, mut initial_unknowns] = [(); 2].map(|()| Vec::new());
    for unknown in file.structure.unknowns {
        match unknown {
            XmlUnknown::Output(u) => outputs.push(references.unknown(&u)?),
            XmlUnknown::InitialUnknown(u) => initial_unknowns.push(references.unknown(&u)?),
            XmlUnknown::Other => {}
        }
    }
    Ok(Description {
        fmi: Version::Fmi3,
        by_name: HashMap::new(),
        guid,
        version: file.version,
        tool: file.generation_tool,
        identifier: slave.identifier,
        capabilities: Capabilities {
            needs_execution_tool: slave.needs_execution_tool,
            variable_step: slave.variable_step,
            output_derivative_order: slave.output_derivative_order,
            only_once: slave.only_once,
            saves_state: slave.saves_state,
            serializes_state: slave.serializes_state,
            directional_derivatives: slave.directional_derivatives,
            adjoint_derivatives: slave.adjoint_derivatives,
            event_mode: slave.event_mode,
            intermediate_update: slave.intermediate_update,
            returns_early: slave.returns_early,
            element_dependencies: slave.element_dependencies,
            ..Capabilities::default()
        },
        log_categories: file.log_categories.names(),
        units: file.units.read(),
        default_experiment: file.default_experiment,
        variables,
        outputs,
        initial_unknowns,
        model,
    })
}

/// All variables and their aliases.
fn variables(
    list: Vec<XmlVariable>,
    types: &[XmlType],
    model: &str,
) -> Result<Vec<Variable>, DescriptionError> {
    let lengths: HashMap<u32, usize> = list.iter().filter_map(XmlVariable::length).collect();
    let mut variables = Vec::with_capacity(list.len());
    for xml in list {
        let (access, v) = xml.parts();
        let length = |d: &XmlDimension| match (d.start, d.reference) {
            (Some(start), None) => Some(start),
            (None, Some(reference)) => lengths.get(&reference).copied(),
            _ => None,
        };
        let dimensions: Option<Vec<usize>> = v.dimensions.iter().map(length).collect();
        let dimensions = dimensions.filter(|d| d.iter().all(|n| *n > 0));
        let Some(dimensions) = dimensions else {
            let (model, name) = (model.to_string(), v.name);
            return Err(DescriptionError::Dimension { model, name });
        };
        let aliases = v.aliases.clone();
        let own = variable(access, v, dimensions, types);
        let alias = |a: XmlAlias| Variable {
            name: a.name,
            description: a.description,
            display_unit: a.display_unit.or_else(|| own.display_unit.clone()),
            ..own.clone()
        };
        let aliases: Vec<_> = aliases.into_iter().map(alias).collect();
        variables.push(own);
        variables.extend(aliases);
    }
    Ok(variables)
}

/// What the variable's own element says, else its declared type.
fn variable(
    access: Option<Access>,
    v: Typed,
    dimensions: Vec<usize>,
    types: &[XmlType],
) -> Variable {
    let mut declared = types.iter().map(|XmlType::Type(declared)| declared);
    let declared = declared.find(|t| Some(&t.name) == v.declared.as_ref());
    let number = |of: fn(&Typed) -> Option<f64>| of(&v).or_else(|| of(declared?));
    let text = |of: fn(&Typed) -> &Option<String>| {
        let text = of(&v).as_ref().or_else(|| of(declared?).as_ref());
        text.cloned()
    };
    let [min, max, nominal] = [number(|t| t.min), number(|t| t.max), number(|t| t.nominal)];
    let [unit, display_unit] = [text(|t| &t.unit), text(|t| &t.display_unit)];
    let kind = match access {
        None => Kind::Enumeration(declared.map_or_else(Vec::new, |t| t.items.clone())),
        Some(Access::Real | Access::Float32) => Kind::Real,
        Some(Access::Boolean) => Kind::Boolean,
        Some(Access::String) => Kind::String,
        Some(Access::Binary) => Kind::Binary,
        Some(Access::Clock) => Kind::Clock,
        Some(_) => Kind::Integer,
    };
    let start = match (&kind, v.start) {
        (Kind::String | Kind::Binary, _) => v.starts.into_iter().map(|s| s.value).collect(),
        (_, Some(list)) => list.split_whitespace().map(String::from).collect(),
        (_, None) => Vec::new(),
    };
    let is_settled = matches!(
        v.causality,
        Causality::Parameter | Causality::StructuralParameter | Causality::CalculatedParameter
    );
    let variability = match &kind {
        _ if is_settled => Variability::Fixed,
        Kind::Real => Variability::Continuous,
        _ => Variability::Discrete,
    };
    Variable {
        min,
        max,
        nominal,
        unit,
        display_unit,
        access: access.unwrap_or(Access::Int64),
        kind,
        start,
        dimensions,
        element: None,
        reference: v.reference,
        causality: v.causality,
        variability: v.variability.unwrap_or(variability),
        initial: v.initial,
        name: v.name,
        description: v.description,
    }
}

/// The variables by value reference; of aliases the first.
struct References<'a> {
    model: &'a str,
    by_reference: HashMap<u32, usize>,
}

impl<'a> References<'a> {
    fn new(variables: &[Variable], model: &'a str) -> Self {
        let pairs = variables.iter().enumerate().rev();
        let by_reference = pairs.map(|(k, v)| (v.reference, k)).collect();
        Self {
            model,
            by_reference,
        }
    }

    fn index(&self, reference: &str) -> Result<usize, DescriptionError> {
        let number = reference.parse().ok();
        let found = number.and_then(|n: u32| self.by_reference.get(&n));
        found.copied().ok_or_else(|| {
            let [model, reference] = [self.model, reference].map(str::to_string);
            DescriptionError::Reference { model, reference }
        })
    }

    fn unknown(&self, u: &Listed) -> Result<Unknown, DescriptionError> {
        let known = u.dependencies.as_deref().map(str::split_whitespace);
        let known = known.map(|words| words.map(|w| self.index(w)).collect());
        Ok(Unknown {
            variable: self.index(&u.reference)?,
            dependencies: known.transpose()?,
        })
    }
}

#[derive(Deserialize)]
struct CoSimulation {
    #[serde(rename = "@modelIdentifier")]
    identifier: String,
    #[serde(rename = "@needsExecutionTool", default)]
    needs_execution_tool: bool,
    #[serde(rename = "@canHandleVariableCommunicationStepSize", default)]
    variable_step: bool,
    #[serde(rename = "@maxOutputDerivativeOrder", default)]
    output_derivative_order: u32,
    #[serde(rename = "@canBeInstantiatedOnlyOncePerProcess", default)]
    only_once: bool,
    #[serde(rename = "@canGetAndSetFMUState", default)]
    saves_state: bool,
    #[serde(rename = "@canSerializeFMUState", default)]
    serializes_state: bool,
    #[serde(rename = "@providesDirectionalDerivatives", default)]
    directional_derivatives: bool,
    #[serde(rename = "@providesAdjointDerivatives", default)]
    adjoint_derivatives: bool,
    #[serde(rename = "@hasEventMode", default)]
    event_mode: bool,
    #[serde(rename = "@providesIntermediateUpdate", default)]
    intermediate_update: bool,
    #[serde(rename = "@canReturnEarlyAfterIntermediateUpdate", default)]
    returns_early: bool,
    #[serde(rename = "@providesPerElementDependencies", default)]
    element_dependencies: bool,
}

#[derive(Default, Deserialize)]
struct Types {
    #[serde(rename = "$value", default)]
    types: Vec<XmlType>,
}

#[derive(Deserialize)]
enum XmlType {
    #[serde(
        rename = "Float64Type",
        alias = "Float32Type",
        alias = "Int8Type",
        alias = "UInt8Type",
        alias = "Int16Type",
        alias = "UInt16Type",
        alias = "Int32Type",
        alias = "UInt32Type",
        alias = "Int64Type",
        alias = "UInt64Type",
        alias = "BooleanType",
        alias = "StringType",
        alias = "BinaryType",
        alias = "ClockType",
        alias = "EnumerationType"
    )]
    Type(Typed),
}

#[derive(Default, Deserialize)]
struct Variables {
    #[serde(rename = "$value", default)]
    variables: Vec<XmlVariable>,
}

#[derive(Deserialize)]
enum XmlVariable {
    Float32(Typed),
    Float64(Typed),
    Int8(Typed),
    UInt8(Typed),
    Int16(Typed),
    UInt16(Typed),
    Int32(Typed),
    UInt32(Typed),
    Int64(Typed),
    UInt64(Typed),
    Boolean(Typed),
    String(Typed),
    Binary(Typed),
    Enumeration(Typed),
    Clock(Typed),
}

impl XmlVariable {
    /// How it is accessed, None for an enumeration; and what it says.
    fn parts(self) -> (Option<Access>, Typed) {
        match self {
            Self::Float32(v) => (Some(Access::Float32), v),
            Self::Float64(v) => (Some(Access::Real), v),
            Self::Int8(v) => (Some(Access::Int8), v),
            Self::UInt8(v) => (Some(Access::UInt8), v),
            Self::Int16(v) => (Some(Access::Int16), v),
            Self::UInt16(v) => (Some(Access::UInt16), v),
            Self::Int32(v) => (Some(Access::Integer), v),
            Self::UInt32(v) => (Some(Access::UInt32), v),
            Self::Int64(v) => (Some(Access::Int64), v),
            Self::UInt64(v) => (Some(Access::UInt64), v),
            Self::Boolean(v) => (Some(Access::Boolean), v),
            Self::String(v) => (Some(Access::String), v),
            Self::Binary(v) => (Some(Access::Binary), v),
            Self::Enumeration(v) => (None, v),
            Self::Clock(v) => (Some(Access::Clock), v),
        }
    }

    /// The length that it gives to arrays whose dimension names it.
    fn length(&self) -> Option<(u32, usize)> {
        let Self::UInt64(v) = self else {
            return None;
        };
        Some((v.reference, v.start.as_deref()?.trim().parse().ok()?))
    }
}

/// A variable or a declared type.
#[derive(Deserialize)]
struct Typed {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@valueReference", default)]
    reference: u32,
    #[serde(rename = "@description", default)]
    description: String,
    #[serde(rename = "@causality", default)]
    causality: Causality,
    #[serde(rename = "@variability")]
    variability: Option<Variability>,
    #[serde(rename = "@initial")]
    initial: Option<Initial>,
    #[serde(rename = "@declaredType")]
    declared: Option<String>,
    #[serde(rename = "@start")]
    start: Option<String>,
    #[serde(rename = "@min")]
    min: Option<f64>,
    #[serde(rename = "@max")]
    max: Option<f64>,
    #[serde(rename = "@nominal")]
    nominal: Option<f64>,
    #[serde(rename = "@unit")]
    unit: Option<String>,
    #[serde(rename = "@displayUnit")]
    display_unit: Option<String>,
    #[serde(rename = "Dimension", default)]
    dimensions: Vec<XmlDimension>,
    #[serde(rename = "Start", default)]
    starts: Vec<XmlStart>,
    #[serde(rename = "Alias", default)]
    aliases: Vec<XmlAlias>,
    #[serde(rename = "Item", default)]
    items: Vec<Item>,
}

#[derive(Deserialize)]
struct XmlDimension {
    #[serde(rename = "@start")]
    start: Option<usize>,
    #[serde(rename = "@valueReference")]
    reference: Option<u32>,
}

#[derive(Deserialize)]
struct XmlStart {
    #[serde(rename = "@value")]
    value: String,
}

#[derive(Clone, Deserialize)]
struct XmlAlias {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@description", default)]
    description: String,
    #[serde(rename = "@displayUnit")]
    display_unit: Option<String>,
}

#[derive(Default, Deserialize)]
struct Structure {
    #[serde(rename = "$value", default)]
    unknowns: Vec<XmlUnknown>,
}

#[derive(Deserialize)]
enum XmlUnknown {
    Output(Listed),
    InitialUnknown(Listed),
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
struct Listed {
    #[serde(rename = "@valueReference")]
    reference: String,
    #[serde(rename = "@dependencies")]
    dependencies: Option<String>,
}
