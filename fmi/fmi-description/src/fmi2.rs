//! Reads variables and dependencies of a model description of FMI 2.0, for `parse`.

use std::collections::HashMap;

use crate::description::{Description, Unknown};
use crate::file::{Items, VariableElements, enumeration, items, unknown};
use crate::variable::{Access, Kind, Variability, Variable};
use crate::xml::{Element, XmlError};

/// Reads what FMI 2.0 describes in its own way.
pub fn read(root: &Element, into: &mut Description) -> Result<(), XmlError> {
    let types = root.all_in("TypeDefinitions");
    let types: HashMap<_, _> = types.map(|t| (t.text("name"), t)).collect();
    let enumerations = types.iter();
    let enumerations = enumerations.filter_map(|(name, t)| Some((name, t.child("Enumeration")?)));
    let enumerations = items(enumerations);
    let variables = root.listed("ModelVariables", "ScalarVariable");
    let variables = variables.map(|v| variable(v, &types, &enumerations));
    into.variables = variables.collect::<Result<_, _>>()?;
    let count = into.variables.len();
    into.outputs = unknowns(root, "Outputs", count)?;
    into.derivatives = unknowns(root, "Derivatives", count)?;
    into.initial_unknowns = unknowns(root, "InitialUnknowns", count)?;
    Ok(())
}

/// Tags of the elements that give a variable its type.
const TYPES: [&str; 5] = ["Real", "Integer", "Boolean", "String", "Enumeration"];

fn variable(
    v: &Element,
    types: &HashMap<String, &Element>,
    enumerations: &Items,
) -> Result<Variable, XmlError> {
    let is_type = |child: &&Element| TYPES.contains(&child.tag.as_str());
    let Some(typed) = v.children.iter().find(is_type) else {
        return Err(v.error(format!("variable `{}` has no type", v.text("name"))));
    };
    let declared = typed.get("declaredType").and_then(|name| types.get(name));
    let declared = declared.and_then(|declared| declared.child(&typed.tag));
    let (kind, access) = match typed.tag.as_str() {
        "Real" => (Kind::Real, Access::Real),
        "Integer" => (Kind::Integer, Access::Integer),
        "Boolean" => (Kind::Boolean, Access::Boolean),
        "String" => (Kind::String, Access::String),
        _ => (enumeration(typed, enumerations)?, Access::Integer),
    };
    let source = VariableElements {
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

/// Reads a list of `ModelStructure`, which counts variables from 1.
fn unknowns(root: &Element, list: &str, count: usize) -> Result<Vec<Unknown>, XmlError> {
    let position = |index: &str| {
        let number = index.trim().parse::<usize>().ok();
        let found = number.filter(|n| (1..=count).contains(n));
        found.map(|n| n - 1).ok_or_else(|| {
            format!(
                "ModelStructure names variable number {index}, but must name one of 1 to {count}"
            )
        })
    };
    let structure = root.child("ModelStructure").into_iter();
    let listed = structure.flat_map(|s| s.listed(list, "Unknown"));
    listed.map(|u| unknown(u, "index", position)).collect()
}
