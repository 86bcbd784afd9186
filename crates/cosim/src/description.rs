//! What the master needs from a `modelDescription.xml`: value references, types, units, and who depends on whom.
//!
//! The `fmi` crate reads the file too, but keeps neither units nor enumeration items, and does not tell an absent `dependencies`
//! (depends on everything) from an empty one (depends on nothing), which decides the order of the exchange.

use std::collections::HashMap;

use anyhow::{Context, Result, anyhow, bail};
use serde::Deserialize;

/// A scalar variable.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Name, unique in the FMU.
    pub name: String,
    /// Value reference, unique among the variables of one type.
    pub reference: u32,
    /// `input`, `output`, `parameter`, `local`, ….
    pub causality: String,
    /// `continuous`, `discrete`, `tunable`, `fixed` or `constant`.
    pub variability: String,
    /// Type.
    pub kind: Kind,
    /// Unit of a real variable.
    pub unit: Option<String>,
    /// True where the value is given (`initial="exact"`), so that it does not depend on anything in initialization.
    pub exact: bool,
}

/// FMI type of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer`.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
    /// `fmi2String`.
    String,
    /// `fmi2Integer` with named values.
    Enumeration(Vec<(String, i32)>),
}

/// A model description.
#[derive(Clone, Debug)]
pub struct Description {
    /// Name of the model.
    pub model: String,
    /// Version of the model, empty where none is given.
    pub version: String,
    /// Program that generated the FMU, empty where none is given.
    pub tool: String,
    /// File stem of the shared library.
    pub identifier: String,
    /// `canBeInstantiatedOnlyOncePerProcess`.
    pub only_once: bool,
    /// `canInterpolateInputs`.
    pub interpolates_inputs: bool,
    /// `maxOutputDerivativeOrder`.
    pub output_derivatives: u32,
    /// Log categories.
    pub log_categories: Vec<String>,
    /// Variables in the order of the file.
    pub variables: Vec<Variable>,
    by_name: HashMap<String, usize>,
    inputs: Vec<usize>,
    outputs: HashMap<usize, Option<Vec<usize>>>,
    initial: HashMap<usize, Option<Vec<usize>>>,
}

impl Description {
    /// Read the text of a `modelDescription.xml`.
    pub fn parse(text: &str) -> Result<Self> {
        let file: xml::File =
            quick_xml::de::from_str(text).context("the model description cannot be read")?;
        if file.fmi_version != "2.0" {
            bail!(
                "model `{}`: FMI version {} is not supported, only 2.0",
                file.model_name,
                file.fmi_version
            );
        }
        let Some(cs) = file.co_simulation else {
            bail!("model `{}` offers no co-simulation", file.model_name);
        };
        let types = file.types.types;
        let variables = file
            .variables
            .variables
            .into_iter()
            .map(|v| variable(v, &types))
            .collect::<Result<Vec<_>>>()?;
        let count = variables.len();
        let by_name = variables
            .iter()
            .enumerate()
            .map(|(k, v)| (v.name.clone(), k))
            .collect();
        let inputs = variables
            .iter()
            .enumerate()
            .filter(|(_, v)| v.causality == "input")
            .map(|(k, _)| k)
            .collect();
        Ok(Self {
            identifier: cs.identifier,
            only_once: cs.only_once,
            interpolates_inputs: cs.interpolates_inputs,
            output_derivatives: cs.output_derivatives,
            log_categories: file
                .log_categories
                .categories
                .into_iter()
                .map(|c| c.name)
                .collect(),
            outputs: unknowns(file.structure.outputs, count)
                .with_context(|| file.model_name.clone())?,
            initial: unknowns(file.structure.initial, count)
                .with_context(|| file.model_name.clone())?,
            model: file.model_name,
            version: file.version,
            tool: file.generation_tool,
            variables,
            by_name,
            inputs,
        })
    }

    /// Index of the variable named `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }

    /// The variable named `name`, or an error that suggests similar names.
    pub fn variable(&self, name: &str) -> Result<&Variable> {
        self.index(name).map(|k| &self.variables[k]).ok_or_else(|| {
            let stem = name.split(['[', '.']).next().unwrap_or(name);
            let near: Vec<_> = self
                .variables
                .iter()
                .map(|v| v.name.as_str())
                .filter(|v| v.starts_with(stem))
                .take(5)
                .collect();
            let hint = if near.is_empty() {
                String::new()
            } else {
                format!(" (it has {})", near.join(", "))
            };
            anyhow!("model `{}` has no variable `{name}`{hint}", self.model)
        })
    }

    /// Inputs on which `output` depends directly at a communication point (`initialization` = false) or in initialization mode.
    pub fn feedthrough(&self, output: usize, initialization: bool) -> Vec<usize> {
        let initial = || {
            self.initial.get(&output).or_else(|| {
                (!self.variables[output].exact)
                    .then(|| self.outputs.get(&output))
                    .flatten()
            })
        };
        let listed = if initialization {
            initial()
        } else {
            self.outputs.get(&output)
        };
        match listed {
            Some(Some(known)) => known
                .iter()
                .copied()
                .filter(|k| self.variables[*k].causality == "input")
                .collect(),
            Some(None) => self.inputs.clone(),
            None => Vec::new(),
        }
    }
}

fn variable(v: xml::Variable, types: &[xml::SimpleType]) -> Result<Variable> {
    let declared = |name: &Option<String>| types.iter().find(|t| Some(&t.name) == name.as_ref());
    let (kind, unit) = match (&v.real, &v.integer, &v.boolean, &v.string, &v.enumeration) {
        (Some(r), ..) => (
            Kind::Real,
            r.unit.clone().or_else(|| {
                declared(&r.declared_type)
                    .and_then(|t| t.real.as_ref())
                    .and_then(|r| r.unit.clone())
            }),
        ),
        (_, Some(_), ..) => (Kind::Integer, None),
        (_, _, Some(_), ..) => (Kind::Boolean, None),
        (_, _, _, Some(_), _) => (Kind::String, None),
        (.., Some(e)) => {
            let items = declared(&e.declared_type).and_then(|t| t.enumeration.as_ref());
            (
                Kind::Enumeration(items.map_or_else(Vec::new, |e| {
                    e.items.iter().map(|i| (i.name.clone(), i.value)).collect()
                })),
                None,
            )
        }
        _ => bail!("variable `{}` has no type", v.name),
    };
    Ok(Variable {
        exact: v.initial.as_deref() == Some("exact"),
        reference: v.reference,
        causality: v.causality.unwrap_or_else(|| "local".into()),
        variability: v.variability.unwrap_or_else(|| "continuous".into()),
        name: v.name,
        kind,
        unit,
    })
}

fn unknowns(list: xml::Unknowns, count: usize) -> Result<HashMap<usize, Option<Vec<usize>>>> {
    let position = |index: usize| match index.checked_sub(1) {
        Some(k) if k < count => Ok(k),
        _ => Err(anyhow!(
            "ModelStructure names variable number {index}, but there are {count}"
        )),
    };
    let mut map = HashMap::new();
    for unknown in list.unknowns {
        let known = match &unknown.dependencies {
            None => None,
            Some(text) => {
                let parse = |word: &str| {
                    position(
                        word.parse()
                            .with_context(|| format!("dependency `{word}` is no number"))?,
                    )
                };
                Some(
                    text.split_whitespace()
                        .map(parse)
                        .collect::<Result<Vec<_>>>()?,
                )
            }
        };
        map.insert(position(unknown.index)?, known);
    }
    Ok(map)
}

/// The elements of the file as they stand; only what is read.
mod xml {
    use super::Deserialize;

    #[derive(Deserialize)]
    pub struct File {
        #[serde(rename = "@fmiVersion")]
        pub fmi_version: String,
        #[serde(rename = "@modelName")]
        pub model_name: String,
        #[serde(rename = "@version", default)]
        pub version: String,
        #[serde(rename = "@generationTool", default)]
        pub generation_tool: String,
        #[serde(rename = "CoSimulation")]
        pub co_simulation: Option<CoSimulation>,
        #[serde(rename = "LogCategories", default)]
        pub log_categories: LogCategories,
        #[serde(rename = "TypeDefinitions", default)]
        pub types: Types,
        #[serde(rename = "ModelVariables")]
        pub variables: Variables,
        #[serde(rename = "ModelStructure", default)]
        pub structure: Structure,
    }
    #[derive(Deserialize)]
    pub struct CoSimulation {
        #[serde(rename = "@modelIdentifier")]
        pub identifier: String,
        #[serde(rename = "@canBeInstantiatedOnlyOncePerProcess", default)]
        pub only_once: bool,
        #[serde(rename = "@canInterpolateInputs", default)]
        pub interpolates_inputs: bool,
        #[serde(rename = "@maxOutputDerivativeOrder", default)]
        pub output_derivatives: u32,
    }
    #[derive(Default, Deserialize)]
    pub struct LogCategories {
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
        #[serde(rename = "Real")]
        pub real: Option<Typed>,
        #[serde(rename = "Enumeration")]
        pub enumeration: Option<Enumeration>,
    }
    #[derive(Deserialize)]
    pub struct Enumeration {
        #[serde(rename = "Item", default)]
        pub items: Vec<Item>,
    }
    #[derive(Deserialize)]
    pub struct Item {
        #[serde(rename = "@name")]
        pub name: String,
        #[serde(rename = "@value")]
        pub value: i32,
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
        #[serde(rename = "@initial")]
        pub initial: Option<String>,
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
        #[serde(rename = "@unit")]
        pub unit: Option<String>,
        #[serde(rename = "@declaredType")]
        pub declared_type: Option<String>,
    }
    #[derive(Default, Deserialize)]
    pub struct Structure {
        #[serde(rename = "Outputs", default)]
        pub outputs: Unknowns,
        #[serde(rename = "InitialUnknowns", default)]
        pub initial: Unknowns,
    }
    #[derive(Default, Deserialize)]
    pub struct Unknowns {
        #[serde(rename = "Unknown", default)]
        pub unknowns: Vec<Unknown>,
    }
    #[derive(Deserialize)]
    pub struct Unknown {
        #[serde(rename = "@index")]
        pub index: usize,
        #[serde(rename = "@dependencies")]
        pub dependencies: Option<String>,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"<?xml version="1.0"?>
<fmiModelDescription fmiVersion="2.0" modelName="M" guid="g">
  <CoSimulation modelIdentifier="M_lib" canInterpolateInputs="true" maxOutputDerivativeOrder="1"/>
  <LogCategories><Category name="logStatusError"/></LogCategories>
  <TypeDefinitions>
    <SimpleType name="Mode"><Enumeration><Item name="slow" value="1"/><Item name="fast" value="4"/></Enumeration></SimpleType>
    <SimpleType name="Force"><Real unit="N"/></SimpleType>
  </TypeDefinitions>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="7" causality="input"><Real unit="m" start="0"/></ScalarVariable>
    <ScalarVariable name="w" valueReference="8" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="k" valueReference="0" causality="parameter" variability="fixed"><Enumeration declaredType="Mode" start="1"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="9" causality="output"><Real declaredType="Force"/></ScalarVariable>
    <ScalarVariable name="z" valueReference="10" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="q" valueReference="11" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="4" dependencies="2 3"/><Unknown index="5"/><Unknown index="6" dependencies=""/></Outputs>
    <InitialUnknowns><Unknown index="4" dependencies="1"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>"#;

    #[test]
    fn dependencies_absent_empty_and_listed_differ() {
        let d = Description::parse(TEXT).unwrap();
        assert_eq!(
            d.feedthrough(3, false),
            [1],
            "listed; the parameter is not an input"
        );
        assert_eq!(d.feedthrough(4, false), [0, 1], "absent: all inputs");
        assert_eq!(d.feedthrough(5, false), [0usize; 0], "empty: none");
        assert_eq!(
            d.feedthrough(3, true),
            [0],
            "initialization has its own list"
        );
    }

    #[test]
    fn types_and_units_come_through() {
        let d = Description::parse(TEXT).unwrap();
        assert_eq!(d.variable("y").unwrap().unit.as_deref(), Some("N"));
        assert_eq!(
            d.variable("k").unwrap().kind,
            Kind::Enumeration(vec![("slow".into(), 1), ("fast".into(), 4)])
        );
        assert_eq!(
            (
                d.identifier.as_str(),
                d.output_derivatives,
                d.interpolates_inputs
            ),
            ("M_lib", 1, true)
        );
        assert_eq!(
            d.variable("yy").unwrap_err().to_string(),
            "model `M` has no variable `yy`"
        );
    }

    #[test]
    fn unusable_descriptions_are_refused() {
        for (from, to) in [
            ("\"2.0\"", "\"3.0\""),
            ("<CoSimulation", "<ModelExchange"),
            ("dependencies=\"1\"", "dependencies=\"99\""),
        ] {
            assert!(Description::parse(&TEXT.replace(from, to)).is_err(), "{to}");
        }
    }
}
