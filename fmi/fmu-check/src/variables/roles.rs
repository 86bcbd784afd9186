//! Checks that causality, variability and initial fit together, and that start values are given
//! where they must be, for `variables`.

use fmi_description::Version;

use super::variable::Variable;
use crate::outcome::{Outcome, Promise};

const ROLES: Promise = Promise {
    text: "causality, variability and initial go together; start is given where it must be, and only there",
    why: "importers decide by them what may be set when, and what is computed [FMI 2.0, 2.2.7; FMI 3.0, 2.4.7.4]",
};

pub fn check(variables: &[Variable], version: Version) -> (Promise, Outcome) {
    let mut outcome = Outcome::default();
    independent(variables, version, &mut outcome);
    for v in variables {
        let Variable {
            name,
            causality,
            variability,
            initial,
            ..
        } = *v;
        let is_pair = match causality {
            "parameter" | "calculatedParameter" | "structuralParameter" => {
                matches!(variability, "fixed" | "tunable")
            }
            "input" => matches!(variability, "discrete" | "continuous"),
            "output" => matches!(variability, "constant" | "discrete" | "continuous"),
            "independent" => variability == "continuous",
            _ => true,
        };
        let is_given = v.element.get("initial").is_some();
        let is_initial = match (causality, variability) {
            ("input", _) if version == Version::Fmi3 => initial == "exact",
            ("input" | "independent", _) => !is_given,
            ("parameter" | "structuralParameter", _) | (_, "constant") => initial == "exact",
            ("calculatedParameter", _) | ("local", "fixed" | "tunable") => {
                matches!(initial, "approx" | "calculated")
            }
            _ => true,
        };
        let is_clock = v.typed.tag.as_str() == "Clock";
        // A clock has neither `initial` nor a start value.
        if !is_pair || !(is_initial || is_clock) {
            outcome.fail(format!(
                "`{name}` is {causality}, {variability}, initial `{initial}`, which do not go together"
            ));
        }
        if variability == "continuous" && !v.is_float() {
            outcome.fail(format!(
                "`{name}` is {} and cannot be continuous",
                v.typed.tag.as_str()
            ));
        }
        let wants_start = causality == "input" || matches!(initial, "exact" | "approx");
        let has_start = v.typed.get("start").is_some() || v.typed.child("Start").is_some();
        match (has_start, wants_start && !is_clock) {
            (false, true) => outcome.fail(format!("`{name}` must have a start value")),
            (true, false) => outcome.fail(format!(
                "`{name}` must have no start value, since it is computed"
            )),
            _ => {}
        }
    }
    (ROLES, outcome)
}

/// At most one variable is independent; FMI 3.0 demands one, which is a floating-point number.
fn independent(variables: &[Variable], version: Version, outcome: &mut Outcome) {
    let mut found = variables.iter().filter(|v| v.causality == "independent");
    match (found.next(), found.next(), version) {
        (_, Some(_), _) => outcome.fail("there is more than one independent variable"),
        (None, _, Version::Fmi3) => outcome.fail("there is no independent variable"),
        (Some(v), _, Version::Fmi3) if !v.is_float() => outcome.fail(format!(
            "`{}` is the independent variable and {}, no floating-point number",
            v.name,
            v.typed.tag.as_str()
        )),
        _ => {}
    }
}
