//! Checks dimensions and start values of arrays of FMI 3.0 (section 2.4.7.1), for `variables`.

use fmi_description::xml::Element;

use super::variable::Variable;
use crate::outcome::{Outcome, Promise};

const ARRAYS: Promise = Promise {
    text: "dimensions are fixed sizes or structural parameters, above 0; an array has one start value, or one for each element",
    why: "importers reserve memory for as many elements, and set as many start values [FMI 3.0, 2.4.7.2]",
};

pub fn check(variables: &[Variable]) -> (Promise, Outcome) {
    let mut outcome = Outcome::default();
    for v in variables {
        let sizes: Result<Vec<u64>, String> = v
            .element
            .all("Dimension")
            .map(|d| size(d, variables))
            .collect();
        let sizes = match sizes {
            Ok(sizes) => sizes,
            Err(reason) => {
                outcome.fail(format!("`{}`: {reason}", v.name));
                continue;
            }
        };
        if v.causality == "structuralParameter" && !sizes.is_empty() {
            outcome.fail(format!(
                "`{}` is a structural parameter, which must be a scalar",
                v.name
            ));
        }
        let elements = sizes
            .iter()
            .try_fold(1, |n: u64, size| n.checked_mul(*size));
        let starts = starts(v);
        match elements {
            None => outcome.fail(format!("`{}` has more elements than can be", v.name)),
            Some(elements) if starts > 1 && starts != elements => outcome.fail(format!(
                "`{}` has {elements} elements and {starts} start values",
                v.name
            )),
            Some(_) => {}
        }
    }
    (ARRAYS, outcome)
}

/// Number of start values. Texts and bytes have an element for each.
fn starts(v: &Variable) -> u64 {
    let count = match v.typed.tag.as_str() {
        "String" | "Binary" => v.typed.all("Start").count(),
        _ => v
            .typed
            .get("start")
            .unwrap_or("")
            .split_whitespace()
            .count(),
    };
    count as u64
}

fn size(dimension: &Element, variables: &[Variable]) -> Result<u64, String> {
    let size = match (dimension.get("start"), dimension.get("valueReference")) {
        (Some(size), None) => size,
        (None, Some(reference)) => {
            let mut found = variables.iter().filter(|v| v.reference == reference.trim());
            let v = found.next();
            let v =
                v.ok_or_else(|| format!("its size is that of {reference}, which is not there"))?;
            let is_fixed = v.causality == "structuralParameter" || v.variability == "constant";
            if v.typed.tag.as_str() != "UInt64" || !is_fixed {
                return Err(format!(
                    "its size is `{}`, which must be UInt64, and a structural parameter or constant",
                    v.name
                ));
            }
            v.typed.get("start").unwrap_or("")
        }
        _ => return Err("a dimension must have either start or valueReference".into()),
    };
    match size.trim().parse() {
        Ok(size) if size > 0 => Ok(size),
        _ => Err(format!(
            "a dimension has the size `{size}`, which must be above 0"
        )),
    }
}
