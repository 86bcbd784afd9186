//! Checks clocks of FMI 3.0 (sections 2.2.8, 2.4.7.4) and clocked variables, for `variables`.

use fmi_description::xml::Element;

use super::variable::Variable;
use crate::outcome::{Outcome, Promise};

const CLOCKS: Promise = Promise {
    text: "clocks have the interval that their kind wants; `clocks` and `previous` name clocks and variables that are there",
    why: "importers tick clocks by it, and read clocked variables only when their clock ticks [FMI 3.0, 2.2.8, 2.4.7.5]",
};

pub fn check(root: &Element, variables: &[Variable]) -> (Promise, Outcome) {
    let mut outcome = Outcome::default();
    let is_scheduled = root.child("ScheduledExecution").is_some();
    for v in variables {
        if v.typed.tag.as_str() == "Clock" {
            clock(v, is_scheduled, &mut outcome);
        }
        if let Some(clocks) = v.element.get("clocks") {
            for reference in clocks.split_whitespace() {
                match at(reference, variables).map(|c| c.typed.tag.as_str()) {
                    Some("Clock") => {}
                    Some(_) => outcome.fail(format!(
                        "`{}` belongs to {reference}, which is no clock",
                        v.name
                    )),
                    None => outcome.fail(format!(
                        "`{}` belongs to {reference}, which is not there",
                        v.name
                    )),
                }
            }
            if !matches!(v.variability, "discrete" | "tunable") {
                outcome.fail(format!(
                    "`{}` belongs to a clock and is {}: it must be discrete or tunable",
                    v.name, v.variability
                ));
            }
        }
        if let Some(reference) = v.element.get("previous") {
            previous(v, reference, variables, &mut outcome);
        }
    }
    (CLOCKS, outcome)
}

fn clock(v: &Variable, is_scheduled: bool, outcome: &mut Outcome) {
    let name = v.name;
    if !matches!(v.causality, "input" | "output" | "local") {
        outcome.fail(format!(
            "clock `{name}` must be an input, an output or local"
        ));
    }
    let kind = v.inherited("intervalVariability").unwrap_or("");
    let has = |attribute| v.inherited(attribute).is_some();
    if kind == "constant" && !has("intervalDecimal") && !has("intervalCounter") {
        outcome.fail(format!(
            "clock `{name}` is {kind} and must have an interval"
        ));
    }
    if v.number("intervalDecimal")
        .is_some_and(|t| t.is_nan() || t <= 0.0)
    {
        outcome.fail(format!("clock `{name}`: intervalDecimal must be above 0"));
    }
    if v.number("shiftDecimal")
        .is_some_and(|t| t.is_nan() || t < 0.0)
    {
        outcome.fail(format!("clock `{name}`: shiftDecimal must be at least 0"));
    }
    if v.number("intervalCounter") == Some(0.0) {
        outcome.fail(format!("clock `{name}`: intervalCounter must be above 0"));
    }
    if (has("intervalCounter") || has("shiftCounter")) && !has("resolution") {
        outcome.fail(format!(
            "clock `{name}` counts its interval and must have a resolution"
        ));
    }
    if is_scheduled && v.causality == "input" && !has("priority") {
        outcome.fail(format!(
            "clock `{name}` must have a priority for scheduled execution"
        ));
    }
}

fn previous(v: &Variable, reference: &str, variables: &[Variable], outcome: &mut Outcome) {
    let name = v.name;
    let is_state = v.is_clocked() && v.variability == "discrete";
    if !is_state {
        outcome.fail(format!(
            "`{name}` has a previous value and must be discrete and belong to a clock"
        ));
    }
    match at(reference, variables) {
        None => outcome.fail(format!(
            "`{name}`: its previous value {reference} is not there"
        )),
        Some(other) if other.reference == v.reference => {
            outcome.fail(format!("`{name}` is its own previous value"));
        }
        Some(other)
            if other.typed.tag.as_str() != v.typed.tag.as_str()
                || other.variability != "discrete" =>
        {
            outcome.fail(format!(
                "`{name}` is {}; its previous value `{}` must be so too, and discrete",
                v.typed.tag.as_str(),
                other.name
            ));
        }
        Some(_) => {}
    }
}

fn at<'v, 'a>(reference: &str, variables: &'v [Variable<'a>]) -> Option<&'v Variable<'a>> {
    variables.iter().find(|v| v.reference == reference.trim())
}
