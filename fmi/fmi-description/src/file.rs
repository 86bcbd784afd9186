//! Reads what model descriptions of both versions share, for `parse`, `fmi2` and `fmi3`: identity,
//! capabilities, units, and attributes that a variable may inherit from its declared type.

use std::collections::HashMap;
use std::sync::Arc;

use crate::description::{
    Capabilities, DefaultExperiment, Description, Index, Interface, Unknown, Version,
};
use crate::error::DescriptionError;
use crate::remark::Remark;
use crate::unit::Unit;
use crate::variable::{Access, Causality, Initial, Item, Kind, Variability, Variable};
use crate::xml::{Element, XmlError};

/// Interfaces: element and name, in the order of [`Interface`].
const INTERFACES: [(&str, &str); 3] = [
    ("CoSimulation", "Co-Simulation"),
    ("ModelExchange", "Model Exchange"),
    ("ScheduledExecution", "Scheduled Execution"),
];

/// Reads all but the variables and their dependencies. Identifier and capabilities are those of the
/// first of the interfaces `wanted` that there is.
pub fn read_head(
    root: &Element,
    fmi: Version,
    wanted: &[Interface],
) -> Result<Description, DescriptionError> {
    let model = root.text("modelName");
    let guid = root.required(match fmi {
        Version::Fmi2 => "guid",
        Version::Fmi3 => "instantiationToken",
    })?;
    let mut offered = INTERFACES.to_vec();
    offered.retain(|(tag, _)| root.child(tag).is_some());
    let interfaces: Vec<_> = offered.iter().map(|(_, name)| *name).collect();
    let mut found = wanted.iter().filter_map(|wanted| {
        let (tag, _) = INTERFACES[*wanted as usize];
        Some((*wanted, root.child(tag)?))
    });
    let Some((interface, slave)) = found.next() else {
        let offered = match interfaces.as_slice() {
            [] => "no interface".into(),
            names => format!("{} only", names.join(" and ")),
        };
        let wanted = wanted.iter().map(|wanted| INTERFACES[*wanted as usize].1);
        let wanted = Vec::from_iter(wanted).join(" or ");
        return Err(DescriptionError::NoInterface {
            model,
            offered,
            wanted,
        });
    };
    let identifier = slave.required("modelIdentifier")?;
    let mut remarks = Vec::new();
    if !is_file_name(&identifier) {
        return Err(DescriptionError::Identifier { model, identifier });
    }
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if !identifier.chars().all(is_word) || identifier.starts_with(|c: char| c.is_ascii_digit()) {
        remarks.push(Remark::Identifier(identifier.clone()));
    }
    let categories = root.all_in("LogCategories");
    let units = root.listed("UnitDefinitions", "Unit").map(Unit::read);
    Ok(Description {
        fmi,
        guid,
        version: root.text("version"),
        tool: root.text("generationTool"),
        identifier,
        capabilities: capabilities(slave, fmi)?,
        interface,
        log_categories: categories.map(|category| category.text("name")).collect(),
        units: units.collect::<Result<_, _>>()?,
        default_experiment: default_experiment(root)?,
        variables: Vec::new(),
        outputs: Vec::new(),
        model_exchange: root.child("ModelExchange").is_some(),
        interfaces,
        derivatives: Vec::new(),
        event_indicators: root.whole("numberOfEventIndicators")?.unwrap_or(0),
        initial_unknowns: Vec::new(),
        remarks,
        index: Index::default(),
        model,
    })
}

/// Whether it names a file in a folder, and none elsewhere.
fn is_file_name(identifier: &str) -> bool {
    let is_path = |c: char| c.is_control() || matches!(c, '/' | '\\' | ':');
    !matches!(identifier, "" | "." | "..") && !identifier.contains(is_path)
}

/// Reads the capabilities; those that the version does not have are ignored.
fn capabilities(slave: &Element, fmi: Version) -> Result<Capabilities, XmlError> {
    let both = |name| slave.flag(name);
    let in_2 = |name| Ok(fmi == Version::Fmi2 && slave.flag(name)?);
    let in_3 = |name| Ok(fmi == Version::Fmi3 && slave.flag(name)?);
    let spelt = |in_2, in_3| match fmi {
        Version::Fmi2 => slave.flag(in_2),
        Version::Fmi3 => slave.flag(in_3),
    };
    let order = slave.whole("maxOutputDerivativeOrder")?;
    let internal_step = slave.number("fixedInternalStepSize")?;
    Ok(Capabilities {
        needs_execution_tool: both("needsExecutionTool")?,
        variable_step: both("canHandleVariableCommunicationStepSize")?,
        interpolates_inputs: in_2("canInterpolateInputs")?,
        output_derivative_order: order.unwrap_or(0),
        asynchronous: in_2("canRunAsynchronuously")?,
        only_once: both("canBeInstantiatedOnlyOncePerProcess")?,
        own_memory: in_2("canNotUseMemoryManagementFunctions")?,
        saves_state: spelt("canGetAndSetFMUstate", "canGetAndSetFMUState")?,
        serializes_state: spelt("canSerializeFMUstate", "canSerializeFMUState")?,
        directional_derivatives: spelt(
            "providesDirectionalDerivative",
            "providesDirectionalDerivatives",
        )?,
        adjoint_derivatives: in_3("providesAdjointDerivatives")?,
        event_mode: in_3("hasEventMode")?,
        intermediate_update: in_3("providesIntermediateUpdate")?,
        returns_early: in_3("canReturnEarlyAfterIntermediateUpdate")?,
        element_dependencies: in_3("providesPerElementDependencies")?,
        completes_steps: match fmi {
            Version::Fmi2 => !slave.flag("completedIntegratorStepNotNeeded")?,
            Version::Fmi3 => {
                slave.get("needsCompletedIntegratorStep").is_none()
                    || slave.flag("needsCompletedIntegratorStep")?
            }
        },
        internal_step: internal_step.filter(|_| fmi == Version::Fmi3),
    })
}

fn default_experiment(root: &Element) -> Result<DefaultExperiment, XmlError> {
    let Some(element) = root.child("DefaultExperiment") else {
        return Ok(DefaultExperiment::default());
    };
    Ok(DefaultExperiment {
        start: element.number("startTime")?,
        stop: element.number("stopTime")?,
        tolerance: element.number("tolerance")?,
        step: element.number("stepSize")?,
    })
}

/// The items of declared types, which all variables of a type share.
pub type Items = HashMap<String, Result<Arc<[Item]>, XmlError>>;

/// Reads the items of types, given by their names.
pub fn items<'a>(types: impl Iterator<Item = (&'a String, &'a Element)>) -> Items {
    let item = |item: &Element| {
        Ok(Item {
            name: item.required("name")?,
            value: item.must("value", item.whole("value")?)?,
        })
    };
    let all = |declared: &'a Element| declared.all("Item").map(item).collect();
    let read = |(name, declared): (&'a String, _)| (name.clone(), all(declared));
    types.map(read).collect()
}

/// The kind of an enumeration, whose type is named by `typed`.
pub fn enumeration(typed: &Element, items: &Items) -> Result<Kind, XmlError> {
    let own = typed.get("declaredType").and_then(|name| items.get(name));
    Ok(Kind::Enumeration(
        own.cloned().unwrap_or_else(|| Ok([].into()))?,
    ))
}

/// Reads an entry of `ModelStructure`. `index` finds the variables that it names, its own in the
/// attribute `key`, or says why there is none.
pub fn unknown(
    listed: &Element,
    key: &str,
    index: impl Fn(&str) -> Result<usize, String>,
) -> Result<Unknown, XmlError> {
    let index = |word: &str| index(word).map_err(|what| listed.error(what));
    let known = listed.get("dependencies").map(str::split_whitespace);
    let known = known.map(|words| words.map(index).collect::<Result<_, _>>());
    Ok(Unknown {
        variable: index(&listed.required(key)?)?,
        dependencies: known.transpose()?,
    })
}

/// The elements that describe a variable: its own, that of its type (in FMI 3.0 the same), and that
/// of its declared type.
#[derive(Clone, Copy)]
pub struct VariableElements<'a> {
    pub variable: &'a Element,
    pub typed: &'a Element,
    pub declared: Option<&'a Element>,
}

impl<'a> VariableElements<'a> {
    /// The element that has an attribute: the variable's, else that of its declared type.
    pub fn element_with(&self, attribute: &str) -> Option<&'a Element> {
        let mut elements = [Some(self.typed), self.declared].into_iter().flatten();
        elements.find(|element| element.get(attribute).is_some())
    }

    fn number(&self, attribute: &str) -> Result<Option<f64>, XmlError> {
        self.element_with(attribute)
            .map_or(Ok(None), |element| element.number(attribute))
    }

    fn unit(&self, attribute: &str) -> Option<String> {
        let name = Unit::name_in(self.element_with(attribute)?, attribute);
        name.map(str::to_string)
    }

    /// Reads the variable as a scalar without a start value. `variability` is the default.
    pub fn read(
        &self,
        kind: Kind,
        access: Access,
        variability: impl FnOnce(Causality, &Kind) -> Variability,
    ) -> Result<Variable, XmlError> {
        let v = self.variable;
        let causality = v.word("causality", Causality::WORDS)?.unwrap_or_default();
        let own = v.word("variability", Variability::WORDS)?;
        let relative = self.element_with("relativeQuantity");
        Ok(Variable {
            name: v.required("name")?,
            description: v.text("description"),
            reference: v.must("valueReference", v.whole("valueReference")?)?,
            dimensions: Vec::new(),
            element: None,
            causality,
            variability: own.unwrap_or_else(|| variability(causality, &kind)),
            initial: v.word("initial", Initial::WORDS)?,
            start: Vec::new(),
            min: self.number("min")?,
            max: self.number("max")?,
            nominal: self.number("nominal")?,
            unit: self.unit("unit"),
            display_unit: self.unit("displayUnit"),
            is_relative: relative.map_or(Ok(false), |e| e.flag("relativeQuantity"))?,
            derivative: self.typed.whole("derivative")?,
            mime_type: (self.element_with("mimeType")).map(|e| e.text("mimeType")),
            clocks: Vec::new(),
            timing: None,
            kind,
            access,
        })
    }
}
