//! Variables of FMI 2.0 against what the standard asks of them beyond the schema (sections 2.2.7 and 2.2.9).

use std::collections::{BTreeMap, BTreeSet};

use super::outcome::{Outcome, Promise, Report};
use super::xml::Element;

const AREA: &str = "variables";
const NAMES: Promise = Promise {
    text: "names are unique; structured names follow their grammar",
    why: "importers find variables by name, and build trees and arrays from structured names",
};
const REFERENCES: Promise = Promise {
    text: "one value reference is one quantity: of two variables that share it, at most one can be set",
    why: "setting the one silently changes the other",
};
const ROLES: Promise = Promise {
    text: "causality, variability and initial go together; start is given where it must be, and only there",
    why: "importers decide by them what may be set when, and what is computed",
};
const NUMBERS: Promise = Promise {
    text: "min ≤ start ≤ max, nominal ≠ 0, enumerations start at one of their items",
    why: "importers refuse or clip such start values, and divide by nominal",
};
const UNITS: Promise = Promise {
    text: "units and display units are defined, with base units",
    why: "importers convert by them, or refuse a connection of unlike units",
};
const TYPES: Promise = Promise {
    text: "declared types exist and are of the variable's own kind",
    why: "bounds, units and items are taken from them",
};

/// Tags of the types of a variable.
const KINDS: [&str; 5] = ["Real", "Integer", "Boolean", "String", "Enumeration"];

/// A variable with what the standard fills in.
pub struct Variable<'a> {
    /// Name.
    pub name: &'a str,
    /// The type element.
    pub typed: Element<'a>,
    /// `causality`.
    pub causality: &'a str,
    /// `variability`.
    pub variability: &'a str,
    /// `initial`, or what stands for it if it is left out; empty where there is none.
    pub initial: &'a str,
    element: Element<'a>,
    declared: Option<Element<'a>>,
}

impl<'a> Variable<'a> {
    /// The variables of a model description.
    pub fn all(root: Element<'a>) -> Vec<Self> {
        let list = root.child("ModelVariables");
        let elements = list
            .into_iter()
            .flat_map(|l| l.all("ScalarVariable").collect::<Vec<_>>());
        elements.filter_map(|e| Self::new(root, e)).collect()
    }

    fn new(root: Element<'a>, element: Element<'a>) -> Option<Self> {
        let typed = element.children().find(|c| KINDS.contains(&c.tag()))?;
        let is_real = typed.tag() == "Real";
        let causality = element.get("causality").unwrap_or("local");
        let default = if is_real && causality != "parameter" && causality != "calculatedParameter" {
            "continuous"
        } else if causality.to_lowercase().ends_with("parameter") {
            "fixed"
        } else {
            "discrete"
        };
        // Continuous is the default of the schema, also where it makes no sense; importers read it as discrete for the other types.
        let variability = element.get("variability").unwrap_or(default);
        let initial = element
            .get("initial")
            .unwrap_or(match (causality, variability) {
                ("parameter", _) | ("output" | "local", "constant") => "exact",
                ("input" | "independent", _) => "",
                _ => "calculated",
            });
        let types = root.child("TypeDefinitions");
        let declared = typed.get("declaredType").and_then(|name| {
            let mut all = types?.all("SimpleType").collect::<Vec<_>>().into_iter();
            all.find(|t| t.get("name") == Some(name))
        });
        Some(Self {
            name: element.get("name").unwrap_or(""),
            typed,
            causality,
            variability,
            initial,
            element,
            declared,
        })
    }

    /// What its own type element says, else its declared type.
    fn inherited(&self, attribute: &str) -> Option<&'a str> {
        let of_type = || {
            self.declared?
                .children()
                .find(|c| KINDS.contains(&c.tag()))?
                .get(attribute)
        };
        self.typed.get(attribute).or_else(of_type)
    }

    fn number(&self, attribute: &str) -> Option<f64> {
        self.inherited(attribute)?.trim().parse().ok()
    }

    /// Whether an importer may set it.
    fn is_settable(&self) -> bool {
        matches!(self.causality, "input" | "parameter")
    }
}

/// Check the variables.
pub fn check(root: Element, variables: &[Variable], report: &mut Report) {
    report.push(AREA, NAMES, names(root, variables));
    report.push(AREA, REFERENCES, references(variables));
    report.push(AREA, ROLES, roles(variables));
    report.push(AREA, NUMBERS, numbers(variables));
    report.push(AREA, TYPES, types(variables));
    report.push(AREA, UNITS, units(root, variables));
}

fn names(root: Element, variables: &[Variable]) -> Outcome {
    let mut outcome = Outcome::default();
    let mut seen = BTreeSet::new();
    for Variable { name, .. } in variables {
        if !seen.insert(name) {
            outcome.fail(format!("`{name}` is there twice"));
        }
        if name.contains(['\r', '\n', '\t']) {
            outcome.fail(format!("{name:?} holds a line break or a tabulator"));
        }
        let is_structured = root.get("variableNamingConvention") == Some("structured");
        if is_structured && !is_structured_name(name) {
            outcome.fail(format!(
                "`{name}` is no structured name, which the description claims"
            ));
        }
    }
    outcome
}

/// The grammar of section 2.2.9, as far as brackets, dots and `der(…)` go; quoted parts may hold anything.
fn is_structured_name(name: &str) -> bool {
    let inner = name.strip_prefix("der(").and_then(|n| n.strip_suffix(')'));
    if let Some(inner) = inner {
        let (variable, order) = inner.rsplit_once(',').unwrap_or((inner, "1"));
        return is_structured_name(variable) && order.trim().parse::<u32>().is_ok();
    }
    let mut rest = name;
    loop {
        rest = match rest.strip_prefix('\'') {
            Some(quoted) => match quoted.find('\'') {
                Some(end) if end > 0 => &quoted[end + 1..],
                _ => return false,
            },
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

fn references(variables: &[Variable]) -> Outcome {
    let mut outcome = Outcome::default();
    let mut settable = BTreeMap::new();
    for variable in variables.iter().filter(|v| v.is_settable()) {
        let access = match variable.typed.tag() {
            "Enumeration" => "Integer",
            tag => tag,
        };
        let key = (access, variable.element.get("valueReference"));
        if let Some(other) = settable.insert(key, variable.name) {
            let reference = key.1.unwrap_or("");
            outcome.fail(format!(
                "`{other}` and `{}` share {access} {reference}",
                variable.name
            ));
        }
    }
    outcome
}

fn roles(variables: &[Variable]) -> Outcome {
    let mut outcome = Outcome::default();
    if variables
        .iter()
        .filter(|v| v.causality == "independent")
        .count()
        > 1
    {
        outcome.fail("there is more than one independent variable");
    }
    for v in variables {
        let Variable {
            name,
            causality,
            variability,
            initial,
            ..
        } = *v;
        let is_pair = match causality {
            "parameter" | "calculatedParameter" => matches!(variability, "fixed" | "tunable"),
            "input" => matches!(variability, "discrete" | "continuous"),
            "output" => matches!(variability, "constant" | "discrete" | "continuous"),
            "independent" => variability == "continuous",
            _ => true,
        };
        let is_initial = match (causality, variability) {
            ("input" | "independent", _) => v.element.get("initial").is_none(),
            ("parameter", _) | (_, "constant") => initial == "exact",
            ("calculatedParameter", _) | ("local", "fixed" | "tunable") => {
                matches!(initial, "approx" | "calculated")
            }
            _ => true,
        };
        if !is_pair || !is_initial {
            outcome.fail(format!(
                "`{name}` is {causality}, {variability}, initial `{initial}`, which do not go together"
            ));
        }
        if variability == "continuous" && v.typed.tag() != "Real" {
            outcome.fail(format!(
                "`{name}` is {} and cannot be continuous",
                v.typed.tag()
            ));
        }
        let wants_start = causality == "input" || matches!(initial, "exact" | "approx");
        match (v.typed.get("start"), wants_start) {
            (None, true) => outcome.fail(format!("`{name}` must have a start value")),
            (Some(_), false) => outcome.fail(format!(
                "`{name}` must have no start value, since it is computed"
            )),
            _ => {}
        }
    }
    outcome
}

fn numbers(variables: &[Variable]) -> Outcome {
    let mut outcome = Outcome::default();
    for v in variables {
        let name = v.name;
        let start = v
            .typed
            .get("start")
            .and_then(|s| s.trim().parse::<f64>().ok());
        let (min, max) = (v.number("min"), v.number("max"));
        if let (Some(min), Some(max)) = (min, max)
            && min > max
        {
            outcome.fail(format!("`{name}`: min {min} is above max {max}"));
        }
        if let Some(start) = start {
            if !start.is_finite() && v.typed.tag() == "Real" {
                outcome.remark(format!("`{name}` starts at {start}"));
            }
            if min.is_some_and(|min| start < min) || max.is_some_and(|max| start > max) {
                let [min, max] = [min, max].map(|b| b.map_or("nothing".into(), |b| b.to_string()));
                outcome.fail(format!(
                    "`{name}` starts at {start}, outside {min} to {max}"
                ));
            }
        }
        if v.number("nominal") == Some(0.0) {
            outcome.fail(format!("`{name}` has nominal 0"));
        }
        let items = v.declared.and_then(|t| t.child("Enumeration"));
        let items = items.map(|e| {
            e.all("Item")
                .filter_map(|i| i.number("value"))
                .collect::<Vec<_>>()
        });
        if let (Some(start), Some(items)) = (start, items)
            && !items.contains(&start)
        {
            outcome.fail(format!(
                "`{name}` starts at {start}, which is no item of its enumeration"
            ));
        }
    }
    outcome
}

fn types(variables: &[Variable]) -> Outcome {
    let mut outcome = Outcome::default();
    for v in variables {
        let Some(name) = v.typed.get("declaredType") else {
            continue;
        };
        let tag = v.typed.tag();
        match v.declared {
            None => outcome.fail(format!("`{}`: there is no type `{name}`", v.name)),
            Some(declared) if declared.child(tag).is_none() => {
                outcome.fail(format!("`{}` is {tag}, its type `{name}` is not", v.name));
            }
            Some(_) => {}
        }
    }
    outcome
}

fn units(root: Element, variables: &[Variable]) -> Outcome {
    let mut outcome = Outcome::default();
    let list = root.child("UnitDefinitions");
    let units: Vec<_> = list
        .into_iter()
        .flat_map(|l| l.all("Unit").collect::<Vec<_>>())
        .collect();
    let mut without_base = BTreeSet::new();
    for v in variables.iter().filter(|v| v.typed.tag() == "Real") {
        let (unit, display) = (v.inherited("unit"), v.inherited("displayUnit"));
        let defined = units
            .iter()
            .find(|u| u.get("name") == unit && unit.is_some());
        match (unit, defined, display) {
            (None, _, Some(display)) => {
                outcome.fail(format!(
                    "`{}` has displayUnit `{display}` and no unit",
                    v.name
                ));
            }
            (Some(unit), None, _) => {
                outcome.fail(format!("`{}`: unit `{unit}` is not defined", v.name));
            }
            (Some(unit), Some(defined), display) => {
                if defined.child("BaseUnit").is_none() && without_base.insert(unit) {
                    outcome.remark(format!(
                        "unit `{unit}` has no BaseUnit: nothing tells what it is"
                    ));
                }
                let is_defined = |d: &str| {
                    d == unit || defined.all("DisplayUnit").any(|u| u.get("name") == Some(d))
                };
                if let Some(display) = display.filter(|d| !is_defined(d)) {
                    outcome.fail(format!(
                        "`{}`: displayUnit `{display}` is not defined for unit `{unit}`",
                        v.name
                    ));
                }
            }
            (None, ..) => {}
        }
    }
    outcome
}
