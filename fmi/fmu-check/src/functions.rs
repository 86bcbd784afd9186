//! The functions that a library must export, by version and interfaces.

use fmi_description::xml::Element;
use fmi_import::standard::{FMI2, FMI3, Function, Interface};

/// What an FMU with this model description must export; None for a version whose functions are not
/// known here.
pub fn required(root: &Element, version: &str) -> Option<Vec<String>> {
    let known = match version {
        "2.0" => FMI2,
        version if version.starts_with("3.") => FMI3,
        _ => return None,
    };
    let is_required = |function: &&Function| match function.interface {
        Interface::Shared => true,
        own => root.child(&format!("{own:?}")).is_some(),
    };
    let mut names: Vec<String> = known
        .iter()
        .filter(is_required)
        .map(|function| function.name.into())
        .collect();
    names.sort_unstable();
    Some(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counted in the headers of the standard.
    #[test]
    fn each_interface_asks_for_its_functions() {
        let count = |version: &str, interfaces: &str| {
            let text = format!("<d>{interfaces}</d>");
            let root = Element::parse(&text, "f", "d").unwrap();
            required(&root, version).map(|names| names.len())
        };
        let (co_simulation, model_exchange) = ("<CoSimulation/>", "<ModelExchange/>");
        assert_eq!(count("2.0", co_simulation), Some(34));
        assert_eq!(count("2.0", model_exchange), Some(35));
        assert_eq!(
            count("2.0", &[co_simulation, model_exchange].concat()),
            Some(44)
        );
        assert_eq!(count("3.0", co_simulation), Some(62));
        assert_eq!(count("3.0", model_exchange), Some(69));
        assert_eq!(count("1.0", co_simulation), None);
    }
}
