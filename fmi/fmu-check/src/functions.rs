//! The C functions that a library must export, by version and interfaces, for `fmu_check::check`.

use fmi_description::Version;
use fmi_description::xml::Element;
use fmi_import::standard::{FMI2, FMI3, Function, Interface};

/// Names of the functions that the library with this model identifier must export. An FMU may have a
/// library for each interface.
pub fn required(root: &Element, version: Version, identifier: &str) -> Vec<String> {
    let known = match version {
        Version::Fmi2 => FMI2,
        Version::Fmi3 => FMI3,
    };
    let is_required = |function: &&Function| match function.interface {
        Interface::Shared => true,
        own => root
            .child(&format!("{own:?}"))
            .is_some_and(|interface| interface.get("modelIdentifier") == Some(identifier)),
    };
    let mut names: Vec<String> = known
        .iter()
        .filter(is_required)
        .map(|function| function.name.into())
        .collect();
    names.sort_unstable();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counted in the headers of the standard.
    #[test]
    fn each_interface_asks_for_its_functions() {
        let count = |version, interfaces: &str| {
            let text = format!("<d>{interfaces}</d>");
            let root = Element::parse(&text, "f", "d").unwrap();
            required(&root, version, "a").len()
        };
        let (co_simulation, model_exchange) = (
            r#"<CoSimulation modelIdentifier="a"/>"#,
            r#"<ModelExchange modelIdentifier="a"/>"#,
        );
        let elsewhere = [co_simulation, r#"<ModelExchange modelIdentifier="b"/>"#].concat();
        assert_eq!(count(Version::Fmi2, &elsewhere), 34);
        let both = [co_simulation, model_exchange].concat();
        let of_2 = [co_simulation, model_exchange, &both].map(|i| count(Version::Fmi2, i));
        assert_eq!(of_2, [34, 35, 44]);
        let of_3 = [co_simulation, model_exchange].map(|i| count(Version::Fmi3, i));
        assert_eq!(of_3, [62, 69]);
    }
}
