//! Checks the variables of a model description, for `fmu_check::check`, by rules of the standard
//! that the schema does not express (FMI 2.0, sections 2.2.7 and 2.2.9; FMI 3.0, section 2.4.7).

mod arrays;
mod clocks;
mod names;
mod roles;
mod units;
mod values;
mod variable;

use fmi_description::Version;
use fmi_description::xml::Element;

use super::outcome::Report;
pub use variable::Variable;

const AREA: &str = "variables";

pub fn check(root: &Element, variables: &[Variable], version: Version, report: &mut Report) {
    let mut push = |(promise, outcome)| report.push(AREA, promise, outcome);
    push(names::check(root, variables));
    push(match version {
        Version::Fmi2 => names::references_2(variables),
        Version::Fmi3 => names::references_3(variables),
    });
    push(roles::check(variables, version));
    push(values::numbers(variables, version));
    push(values::types(variables));
    push(units::check(root, variables, version));
    if version == Version::Fmi3 {
        push(arrays::check(variables));
        push(clocks::check(root, variables));
    }
}
