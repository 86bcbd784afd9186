//! Checks start values, bounds, nominal values and declared types, for `variables`.

use fmi_description::Version;

use super::variable::{DeclaredType, Variable};
use crate::outcome::{Outcome, Promise};

const NUMBERS: Promise = Promise {
    text: "min ≤ start ≤ max, nominal ≠ 0, enumerations start at one of their items",
    why: "importers refuse or clip such start values, and divide by nominal [FMI 2.0, 2.2.3; FMI 3.0, 2.4.4]",
};
const TYPES: Promise = Promise {
    text: "declared types exist and are of the variable's own kind",
    why: "bounds, units and items are taken from them [FMI 2.0, 2.2.7; FMI 3.0, 2.4.7.5]",
};

impl Variable<'_> {
    /// Start values that are numbers; an array of FMI 3.0 may have several.
    fn starts(&self, version: Version) -> Vec<f64> {
        let text = self.typed.get("start").unwrap_or("");
        let words: Vec<_> = match version {
            Version::Fmi2 => vec![text],
            Version::Fmi3 => text.split_whitespace().collect(),
        };
        words
            .into_iter()
            .filter_map(|word| word.trim().parse().ok())
            .collect()
    }
}

/// Compares numbers with their bounds and items.
pub fn numbers(variables: &[Variable], version: Version) -> (Promise, Outcome) {
    let mut outcome = Outcome::default();
    for v in variables {
        let name = v.name;
        let (min, max) = (v.number("min"), v.number("max"));
        if let (Some(min), Some(max)) = (min, max)
            && min > max
        {
            outcome.fail(format!("`{name}`: min {min} is above max {max}"));
        }
        if v.number("nominal") == Some(0.0) {
            outcome.remark(format!("`{name}` has nominal 0"));
        }
        let is_enumeration = |d: &&DeclaredType| d.kind == "Enumeration";
        let items = v.declared.as_ref().filter(is_enumeration).map(|d| {
            let items = d.attributes.all("Item");
            items
                .filter_map(|i| i.number("value").ok().flatten())
                .collect::<Vec<_>>()
        });
        for start in v.starts(version) {
            if !start.is_finite() && v.is_float() {
                outcome.remark(format!("`{name}` starts at {start}"));
            }
            if min.is_some_and(|min| start < min) || max.is_some_and(|max| start > max) {
                let [min, max] = [min, max].map(|b| b.map_or("nothing".into(), |b| b.to_string()));
                outcome.fail(format!(
                    "`{name}` starts at {start}, outside {min} to {max}"
                ));
            }
            if items.as_ref().is_some_and(|items| !items.contains(&start)) {
                outcome.fail(format!(
                    "`{name}` starts at {start}, which is no item of its enumeration"
                ));
            }
        }
    }
    (NUMBERS, outcome)
}

/// Compares variables with the types that they name.
pub fn types(variables: &[Variable]) -> (Promise, Outcome) {
    let mut outcome = Outcome::default();
    for v in variables {
        let Some(name) = v.typed.get("declaredType") else {
            continue;
        };
        let tag = v.typed.tag.as_str();
        match &v.declared {
            None => outcome.fail(format!("`{}`: there is no type `{name}`", v.name)),
            Some(declared) if declared.kind != tag => {
                outcome.fail(format!("`{}` is {tag}, its type `{name}` is not", v.name));
            }
            Some(_) => {}
        }
    }
    (TYPES, outcome)
}
