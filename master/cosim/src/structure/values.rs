//! Reads the parameter values that a binding of the structure (for `flatten`) or a parameter set
//! (for `System`) gives, with prefixes and mappings applied to their names.

use std::collections::HashMap;

use anyhow::{Context, Result};
use system_structure::{Binding, ParameterMapping, ParameterSet, Sourced};

use super::flat::{Hop, Parameter};
use super::package::Base;

/// Reads the text of a file that a structure names.
pub(super) type Files<'a> = dyn FnMut(&str) -> Result<String> + 'a;

/// Parse the text of the parameter set `file`.
pub fn parse_set(text: &str, file: &str) -> Result<Vec<Parameter>> {
    let set = ParameterSet::parse(text, file).context("parameter set")?;
    Ok(set_values(set, &format!("parameter set `{file}`")))
}

/// The values of a binding of the element `owner` in a structure at `base`, with the names that they
/// have there; `files` reads files.
pub(super) fn binding_values(
    binding: &Binding,
    owner: &str,
    base: Base<'_>,
    files: &mut Files<'_>,
) -> Result<Vec<Parameter>> {
    let mut file = |source: &str, what: &str| {
        let text = base.file(source).and_then(|name| files(&name));
        text.with_context(|| format!("{owner}: {what}"))
    };
    let mut parameters = match &binding.set {
        Sourced::Inline(set) => set_values(set.clone(), "the system structure"),
        Sourced::File(source) => {
            let text = file(source, "parameter set")?;
            parse_set(&text, source).with_context(|| owner.to_string())?
        }
    };
    for parameter in &mut parameters {
        parameter.name.insert_str(0, &binding.prefix);
    }
    let mapping = match &binding.mapping {
        None => return Ok(parameters),
        Some(Sourced::Inline(mapping)) => mapping.clone(),
        Some(Sourced::File(source)) => {
            let text = file(source, "parameter mapping")?;
            ParameterMapping::parse(&text, source).with_context(|| owner.to_string())?
        }
    };
    let named = parameters.iter().map(|p| (p.name.as_str(), p));
    let named: HashMap<_, _> = named.collect();
    let mut mapped = Vec::new();
    for entry in mapping.entries {
        let Some(parameter) = named.get(&*entry.source) else {
            continue;
        };
        let mut parameter = (*parameter).clone();
        parameter.way.push(Hop::from(&entry));
        parameter.name = entry.target;
        mapped.push(parameter);
    }
    Ok(mapped)
}

fn set_values(set: ParameterSet, origin: &str) -> Vec<Parameter> {
    let all = set.parameters.into_iter();
    let parameter = |p: system_structure::Parameter| Parameter {
        name: p.name,
        value: p.value,
        data_type: p.data_type,
        unit: p.unit,
        way: Vec::new(),
        origin: origin.to_string(),
    };
    all.map(parameter).collect()
}
