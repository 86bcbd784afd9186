//! Checks units and display units of floating-point variables, for `variables`.

use std::collections::BTreeSet;

use fmi_description::Version;
use fmi_description::xml::Element;

use super::variable::Variable;
use crate::outcome::{Outcome, Promise};

const UNITS: Promise = Promise {
    text: "units and display units are defined, with base units",
    why: "importers convert by them, or refuse a connection of unlike units [FMI 2.0, 2.2.3; FMI 3.0, 2.4.4]",
};

pub fn check(root: &Element, variables: &[Variable], version: Version) -> (Promise, Outcome) {
    let mut outcome = Outcome::default();
    let units: Vec<_> = root.listed("UnitDefinitions", "Unit").collect();
    let mut without_base = BTreeSet::new();
    for v in variables.iter().filter(|v| v.is_float()) {
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
                    let name = v.name;
                    let fault = format!(
                        "`{name}`: displayUnit `{display}` is not defined for unit `{unit}`"
                    );
                    match version {
                        Version::Fmi2 => outcome.remark(fault), // it is ignored (section 2.2.3)
                        Version::Fmi3 => outcome.fail(fault),
                    }
                }
            }
            (None, ..) => {}
        }
    }
    (UNITS, outcome)
}
