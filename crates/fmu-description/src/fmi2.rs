//! The elements of a file of FMI 2.0 as they stand, and how they become a [`Description`].

use serde::Deserialize;

use crate::xml::{File, check_identifier, required};
use crate::{
    Access, Capabilities, Causality, Description, DescriptionError, Initial, Item, Kind, Unknown,
    Variability, Variable, Version,
};

/// Read the text of a file.
pub fn read(text: &str) -> Result<Description, DescriptionError> {
    let file: File<CoSimulation, Types, Variables, Structure> = quick_xml::de::from_str(text)?;
    let guid = required(file.guid, "@guid")?;
    let model = file.model_name;
    let Some(slave) = file.co_simulation else {
        return Err(DescriptionError::NoCoSimulation { model });
    };
    check_identifier(&model, &slave.identifier)?;
    let types = file.types.types;
    let variables = file.variables.variables.into_iter();
    let variables: Vec<Variable> = variables
        .map(|v| variable(v, &types, &model))
        .collect::<Result<_, _>>()?;
    let unknowns = |list: Unknowns| unknowns(list, variables.len(), &model);
    let outputs = unknowns(file.structure.outputs)?;
    let initial_unknowns = unknowns(file.structure.initial)?;
    Ok(Description {
        fmi: Version::Fmi2,
        by_name: Default::default(),
        guid,
        version: file.version,
        tool: file.generation_tool,
        identifier: slave.identifier,
        capabilities: Capabilities {
            needs_execution_tool: slave.needs_execution_tool,
            variable_step: slave.variable_step,
            interpolates_inputs: slave.interpolates_inputs,
            output_derivative_order: slave.output_derivative_order,
            asynchronous: slave.asynchronous,
            only_once: slave.only_once,
            own_memory: slave.own_memory,
            saves_state: slave.saves_state,
            serializes_state: slave.serializes_state,
            directional_derivatives: slave.directional_derivatives,
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

/// What the variable's own type element says, else its declared type.
fn variable(
    v: ScalarVariable,
    types: &[SimpleType],
    model: &str,
) -> Result<Variable, DescriptionError> {
    let element = [&v.real, &v.integer, &v.boolean, &v.string, &v.enumeration];
    let Some(own) = element.into_iter().find_map(Option::as_ref) else {
        let (model, name) = (model.to_string(), v.name);
        return Err(DescriptionError::NoType { model, name });
    };
    let declared = types
        .iter()
        .find(|t| Some(&t.name) == own.declared.as_ref());
    let enumeration = declared.and_then(|t| t.enumeration.as_ref());
    let inherited = declared.and_then(|t| t.real.as_ref().or(t.integer.as_ref()));
    let number = |of: fn(&Typed) -> Option<f64>| of(own).or_else(|| inherited.and_then(of));
    let text = |of: fn(&Typed) -> &Option<String>| {
        let text = of(own).as_ref().or_else(|| of(inherited?).as_ref());
        text.cloned()
    };
    let items = || enumeration.map_or_else(Vec::new, |e| e.items.clone());
    let (kind, access) = match &v {
        ScalarVariable { real: Some(_), .. } => (Kind::Real, Access::Real),
        ScalarVariable {
            integer: Some(_), ..
        } => (Kind::Integer, Access::Integer),
        ScalarVariable {
            boolean: Some(_), ..
        } => (Kind::Boolean, Access::Boolean),
        ScalarVariable {
            string: Some(_), ..
        } => (Kind::String, Access::String),
        _ => (Kind::Enumeration(items()), Access::Integer),
    };
    Ok(Variable {
        kind,
        access,
        dimensions: Vec::new(),
        element: None,
        start: own.start.iter().cloned().collect(),
        min: number(|t| t.min),
        max: number(|t| t.max),
        nominal: number(|t| t.nominal),
        unit: text(|t| &t.unit),
        display_unit: text(|t| &t.display_unit),
        reference: v.reference,
        causality: v.causality,
        variability: v.variability,
        initial: v.initial,
        name: v.name,
        description: v.description,
    })
}

/// The specification counts variables from 1.
fn unknowns(list: Unknowns, count: usize, model: &str) -> Result<Vec<Unknown>, DescriptionError> {
    let position = |index: &str| {
        let number = index.parse::<usize>().ok();
        let found = number.filter(|n| (1..=count).contains(n));
        found.map(|n| n - 1).ok_or_else(|| {
            let (model, index) = (model.to_string(), index.to_string());
            DescriptionError::Index {
                model,
                index,
                count,
            }
        })
    };
    let unknown = |u: XmlUnknown| {
        let known = u.dependencies.as_deref().map(str::split_whitespace);
        Ok(Unknown {
            variable: position(&u.index)?,
            dependencies: known
                .map(|words| words.map(position).collect::<Result<_, _>>())
                .transpose()?,
        })
    };
    list.unknowns.into_iter().map(unknown).collect()
}

#[derive(Deserialize)]
struct CoSimulation {
    #[serde(rename = "@modelIdentifier")]
    identifier: String,
    #[serde(rename = "@needsExecutionTool", default)]
    needs_execution_tool: bool,
    #[serde(rename = "@canHandleVariableCommunicationStepSize", default)]
    variable_step: bool,
    #[serde(rename = "@canInterpolateInputs", default)]
    interpolates_inputs: bool,
    #[serde(rename = "@maxOutputDerivativeOrder", default)]
    output_derivative_order: u32,
    #[serde(rename = "@canRunAsynchronuously", default)]
    asynchronous: bool,
    #[serde(rename = "@canBeInstantiatedOnlyOncePerProcess", default)]
    only_once: bool,
    #[serde(rename = "@canNotUseMemoryManagementFunctions", default)]
    own_memory: bool,
    #[serde(rename = "@canGetAndSetFMUstate", default)]
    saves_state: bool,
    #[serde(rename = "@canSerializeFMUstate", default)]
    serializes_state: bool,
    #[serde(rename = "@providesDirectionalDerivative", default)]
    directional_derivatives: bool,
}

#[derive(Default, Deserialize)]
struct Types {
    #[serde(rename = "SimpleType", default)]
    types: Vec<SimpleType>,
}

#[derive(Deserialize)]
struct SimpleType {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "Real")]
    real: Option<Typed>,
    #[serde(rename = "Integer")]
    integer: Option<Typed>,
    #[serde(rename = "Enumeration")]
    enumeration: Option<Enumeration>,
}

#[derive(Deserialize)]
struct Enumeration {
    #[serde(rename = "Item", default)]
    items: Vec<Item>,
}

#[derive(Deserialize)]
struct Variables {
    #[serde(rename = "ScalarVariable", default)]
    variables: Vec<ScalarVariable>,
}

#[derive(Deserialize)]
struct ScalarVariable {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@valueReference")]
    reference: u32,
    #[serde(rename = "@description", default)]
    description: String,
    #[serde(rename = "@causality", default)]
    causality: Causality,
    #[serde(rename = "@variability", default)]
    variability: Variability,
    #[serde(rename = "@initial")]
    initial: Option<Initial>,
    #[serde(rename = "Real")]
    real: Option<Typed>,
    #[serde(rename = "Integer")]
    integer: Option<Typed>,
    #[serde(rename = "Boolean")]
    boolean: Option<Typed>,
    #[serde(rename = "String")]
    string: Option<Typed>,
    #[serde(rename = "Enumeration")]
    enumeration: Option<Typed>,
}

#[derive(Deserialize)]
struct Typed {
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
}

#[derive(Default, Deserialize)]
struct Structure {
    #[serde(rename = "Outputs", default)]
    outputs: Unknowns,
    #[serde(rename = "InitialUnknowns", default)]
    initial: Unknowns,
}

#[derive(Default, Deserialize)]
struct Unknowns {
    #[serde(rename = "Unknown", default)]
    unknowns: Vec<XmlUnknown>,
}

#[derive(Deserialize)]
struct XmlUnknown {
    #[serde(rename = "@index")]
    index: String,
    #[serde(rename = "@dependencies")]
    dependencies: Option<String>,
}
