//! Checks names and value references of variables, for `variables`.

use std::collections::{BTreeMap, BTreeSet};

use fmi_description::xml::Element;

use super::variable::Variable;
use crate::outcome::{Outcome, Promise};

const NAMES: Promise = Promise {
    text: "names are unique; structured names follow their grammar",
    why: "importers find variables by name, and build trees and arrays from structured names [FMI 2.0, 2.2.9; FMI 3.0, 2.4.7.5.1]",
};
const SHARED: Promise = Promise {
    text: "one value reference is one quantity: of two variables that share it, at most one can be set",
    why: "setting one silently changes the other [FMI 2.0, 2.2.7]",
};
const UNIQUE: Promise = Promise {
    text: "each value reference is that of one variable",
    why: "importers tell variables apart by it; a second name of a variable is an alias of it [FMI 3.0, 2.4.7.4]",
};

/// Checks names, those of aliases too.
pub fn check(root: &Element, variables: &[Variable]) -> (Promise, Outcome) {
    let is_structured = root.get("variableNamingConvention") == Some("structured");
    let mut outcome = Outcome::default();
    let mut seen = BTreeSet::new();
    for name in variables.iter().flat_map(Variable::names) {
        if name.is_empty() {
            outcome.fail("a variable has an empty name");
        }
        if !seen.insert(name) {
            outcome.fail(format!("`{name}` is there twice"));
        }
        if name.contains(['\r', '\n', '\t']) {
            outcome.fail(format!("{name:?} holds a line break or a tabulator"));
        }
        if is_structured && !is_structured_name(name) {
            outcome.fail(format!(
                "`{name}` is no structured name, which the description claims"
            ));
        }
    }
    (NAMES, outcome)
}

/// The grammar of FMI 2.0, section 2.2.9: brackets, dots and `der(…)`. Quoted parts are not
/// checked.
fn is_structured_name(name: &str) -> bool {
    let inner = name.strip_prefix("der(").and_then(|n| n.strip_suffix(')'));
    if let Some(inner) = inner {
        let (variable, order) = inner.rsplit_once(',').unwrap_or((inner, "1"));
        return is_structured_name(variable) && order.trim().parse::<u32>().is_ok();
    }
    let mut rest = name;
    loop {
        rest = match rest.strip_prefix('\'') {
            Some(quoted) => {
                let mut is_escaped = false;
                let end = quoted.find(|c| {
                    let ends = c == '\'' && !is_escaped;
                    is_escaped = c == '\\' && !is_escaped;
                    ends
                });
                match end {
                    Some(end) if end > 0 => &quoted[end + 1..],
                    _ => return false,
                }
            }
            None => {
                let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
                let (word, after) = rest.split_at(end.unwrap_or(rest.len()));
                if !word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
                    return false;
                }
                after
            }
        };
        if let Some(indices) = rest.strip_prefix('[') {
            let Some((indices, after)) = indices.split_once(']') else {
                return false;
            };
            if !indices.split(',').all(|i| i.trim().parse::<u32>().is_ok()) {
                return false;
            }
            rest = after;
        }
        match rest.strip_prefix('.') {
            Some(next) => rest = next,
            None => return rest.is_empty(),
        }
    }
}

/// Checks value references of FMI 2.0, which variables may share.
pub fn references_2(variables: &[Variable]) -> (Promise, Outcome) {
    let mut outcome = Outcome::default();
    let mut settable = BTreeMap::new();
    for variable in variables.iter().filter(|v| v.is_settable()) {
        let access = match variable.typed.tag.as_str() {
            "Enumeration" => "Integer",
            tag => tag,
        };
        let key = (access, variable.reference);
        if let Some(other) = settable.insert(key, variable.name) {
            let reference = key.1;
            outcome.fail(format!(
                "`{other}` and `{}` share {access} {reference}",
                variable.name
            ));
        }
    }
    (SHARED, outcome)
}

/// Checks value references of FMI 3.0, which variables may not share.
pub fn references_3(variables: &[Variable]) -> (Promise, Outcome) {
    let mut outcome = Outcome::default();
    let mut seen = BTreeMap::new();
    for v in variables {
        let number: Option<u32> = v.reference.parse().ok();
        if let Some(other) = number.and_then(|number| seen.insert(number, v.name)) {
            outcome.fail(format!("`{other}` and `{}` share {}", v.name, v.reference));
        }
    }
    (UNIQUE, outcome)
}
