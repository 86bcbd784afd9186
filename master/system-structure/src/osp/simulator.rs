//! Simulators of a system of the Open Simulation Platform: FMUs with steps of their own, start values
//! and groups of variables.

use std::sync::Arc;

use fmi_description::xml::{Element, XmlError};
use fmi_description::{Description, Variable};

use super::groups::{self, Group};

/// The FMU of a simulator.
pub struct Model {
    /// Its model description, arrays by element.
    pub description: Description,
    /// Name and text of its `OspModelDescription.xml`, if it has one.
    pub groups: Option<(String, String)>,
    /// Source file in the system structure of SSP.
    pub source: String,
}

/// Gives the FMU of a simulator, by its name and source.
pub type Models<'a> = dyn FnMut(&str, &str) -> Result<Arc<Model>, String> + 'a;

pub(super) fn unknown(element: &Element) -> XmlError {
    element.error(format!("the element {} is not known here", element.tag))
}

/// The elements in the element `list` of `node`, which must have one of these tags.
pub(super) fn parts<'a>(
    node: &'a Element,
    list: &str,
    tags: &[&str],
) -> Result<Vec<&'a Element>, XmlError> {
    let all: Vec<_> = node.all_in(list).collect();
    match all.iter().find(|part| !tags.contains(&&*part.tag)) {
        Some(other) => Err(unknown(other)),
        None => Ok(all),
    }
}

/// A simulator: an instance of an FMU.
pub(super) struct Simulator {
    pub name: String,
    pub model: Arc<Model>,
    pub groups: Vec<Group>,
    /// Step of its own, s.
    pub step: Option<f64>,
    /// Variable, type of SSP and value.
    pub values: Vec<(String, &'static str, String)>,
}

impl Simulator {
    pub fn variable(&self, name: &str, node: &Element) -> Result<&Variable, XmlError> {
        let found = self.model.description.variable(name);
        found.map_err(|error| node.error(format!("simulator `{}`: {error}", self.name)))
    }

    pub fn read(
        node: &Element,
        base: f64,
        model: &mut Models<'_>,
        remarks: &mut Vec<String>,
    ) -> Result<Self, XmlError> {
        let (name, source) = (node.required("name")?, node.required("source")?);
        if let Some(other) = node.children.iter().find(|c| c.tag != "InitialValues") {
            return Err(unknown(other));
        }
        let step = node.finite("stepSize")?;
        if let Some(step) = step.filter(|step| *step <= 0.0) {
            return Err(node.wrong(format!("has stepSize = {step} s; it must be above 0")));
        }
        // As in the platform's programs: whole steps, of whole nanoseconds.
        let nanoseconds = |time: f64| (time * 1e9).round().max(1.0);
        let step = step.map(|step| {
        let parts = nanoseconds(step) / nanoseconds(base);
        let own = parts.floor().max(1.0) * base;
        if parts != parts.floor() || parts < 1.0 {
            remarks.push(format!(
                "simulator `{name}` has steps of {own} s instead of stepSize = {step} s: whole multiples of BaseStepSize"
            ));
        }
        own
    });
        let found = model(&name, &source);
        let model = found.map_err(|text| node.error(format!("simulator `{name}`: {text}")))?;
        let mut simulator = Self {
            groups: match &model.groups {
                Some((file, text)) => groups::read(text, file)?,
                None => Vec::new(),
            },
            name,
            model,
            step: step.filter(|step| *step != base),
            values: Vec::new(),
        };
        for value in parts(node, "InitialValues", &["InitialValue"])? {
            let variable = value.required("variable")?;
            simulator.variable(&variable, value)?;
            let Some(given) = value.children.first() else {
                return Err(value.error(format!("InitialValue of `{variable}` has no value")));
            };
            let text = given.required("value")?;
            let (data_type, is_fit) = match given.tag.as_str() {
                "Real" => ("Real", given.finite("value")?.is_some()),
                "Integer" => ("Integer", given.whole::<i32>("value")?.is_some()),
                "Enumeration" => ("Integer", given.whole::<i32>("value")?.is_some()),
                "Boolean" => ("Boolean", given.flag("value").is_ok()),
                "String" => ("String", true),
                _ => return Err(unknown(given)),
            };
            if !is_fit || value.children.len() > 1 {
                let text = format!(
                    "InitialValue of `{variable}` is `{text}`; it must be one {}",
                    given.tag
                );
                return Err(value.error(text));
            }
            simulator.values.push((variable, data_type, text));
        }
        Ok(simulator)
    }
}
