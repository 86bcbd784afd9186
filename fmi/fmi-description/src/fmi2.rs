//! Variables and dependencies in a file of FMI 2.0.

use std::collections::HashMap;

use crate::description::{Description, Unknown};
use crate::error::DescriptionError;
use crate::file::{Source, items, unknown};
use crate::variable::{Access, Kind, Variability, Variable};
use crate::xml::Element;

/// Fill in what stands in this version's own way.
pub fn read(root: &Element, into: &mut Description) -> Result<(), DescriptionError> {
    let types = root.all_in("TypeDefinitions");
    let types: HashMap<_, _> = types.map(|t| (t.text("name"), t)).collect();
    let variables = root.listed("ModelVariables", "ScalarVariable");
    into.variables = variables
        .map(|v| variable(v, &types, &into.model))
        .collect::<Result<_, _>>()?;
    into.outputs = unknowns(root, "Outputs", into)?;
    into.derivatives = unknowns(root, "Derivatives", into)?;
    into.initial_unknowns = unknowns(root, "InitialUnknowns", into)?;
    Ok(())
}

/// The elements that say of which type a variable is.
const TYPES: [&str; 5] = ["Real", "Integer", "Boolean", "String", "Enumeration"];

fn variable(
    v: &Element,
    types: &HashMap<String, &Element>,
    model: &str,
) -> Result<Variable, DescriptionError> {
    let is_type = |child: &&Element| TYPES.contains(&child.tag.as_str());
    let Some(typed) = v.children.iter().find(is_type) else {
        let (model, name) = (model.to_string(), v.text("name"));
        return Err(DescriptionError::NoType { model, name });
    };
    let declared = typed.get("declaredType").and_then(|name| types.get(name));
    let declared = declared.and_then(|declared| declared.child(&typed.tag));
    let (kind, access) = match typed.tag.as_str() {
        "Real" => (Kind::Real, Access::Real),
        "Integer" => (Kind::Integer, Access::Integer),
        "Boolean" => (Kind::Boolean, Access::Boolean),
        "String" => (Kind::String, Access::String),
        _ => (Kind::Enumeration(items(declared)?), Access::Integer),
    };
    let source = Source {
        variable: v,
        typed,
        declared,
    };
    let start = typed.get("start").map(str::to_string);
    Ok(Variable {
        start: start.into_iter().collect(),
        ..source.read(kind, access, |_, _| Variability::Continuous)?
    })
}

/// The specification counts variables from 1.
fn unknowns(
    root: &Element,
    list: &str,
    description: &Description,
) -> Result<Vec<Unknown>, DescriptionError> {
    let count = description.variables.len();
    let position = |index: &str| {
        let number = index.trim().parse::<usize>().ok();
        let found = number.filter(|n| (1..=count).contains(n));
        found.map(|n| n - 1).ok_or_else(|| {
            let (model, index) = (description.model.clone(), index.to_string());
            DescriptionError::Index {
                model,
                index,
                count,
            }
        })
    };
    let structure = root.child("ModelStructure");
    let listed = structure
        .into_iter()
        .flat_map(|s| s.listed(list, "Unknown"));
    listed.map(|u| unknown(u, "index", position)).collect()
}
