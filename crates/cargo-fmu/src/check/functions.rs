//! The functions that a library must export, by version and interfaces.

use super::xml::Element;
use crate::fmi::{Functions2, fmi3};

/// The functions that only one interface has, by its element. FMI 2.0.4, sections 3.2 and 4.2.
const INTERFACES_2: [(&str, &str); 2] = [
    (
        "CoSimulation",
        "fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives fmi2DoStep fmi2CancelStep fmi2GetStatus fmi2GetRealStatus \
         fmi2GetIntegerStatus fmi2GetBooleanStatus fmi2GetStringStatus",
    ),
    (
        "ModelExchange",
        "fmi2EnterEventMode fmi2NewDiscreteStates fmi2EnterContinuousTimeMode fmi2CompletedIntegratorStep fmi2SetTime \
         fmi2SetContinuousStates fmi2GetDerivatives fmi2GetEventIndicators fmi2GetContinuousStates \
         fmi2GetNominalsOfContinuousStates",
    ),
];

/// The same of FMI 3.0.1, sections 3.2, 4.2 and 5.2.
const INTERFACES_3: [(&str, &str); 3] = [
    (
        "CoSimulation",
        "fmi3InstantiateCoSimulation fmi3EnterStepMode fmi3GetOutputDerivatives fmi3DoStep",
    ),
    (
        "ModelExchange",
        "fmi3InstantiateModelExchange fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime \
         fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators fmi3GetContinuousStates \
         fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates",
    ),
    (
        "ScheduledExecution",
        "fmi3InstantiateScheduledExecution fmi3ActivateModelPartition",
    ),
];

/// What an FMU with this model description must export; None for a version whose functions are not
/// known here.
pub fn required(root: Element, version: &str) -> Option<Vec<String>> {
    let (known, interfaces): (&[&str], &[(&str, &str)]) = match version {
        "2.0" => (Functions2::NAMES, &INTERFACES_2),
        version if version.starts_with("3.") => (fmi3::Functions::NAMES, &INTERFACES_3),
        _ => return None,
    };
    let own = || interfaces.iter().flat_map(|(_, names)| names.split(' '));
    let is_shared = |name: &&str| own().all(|own| own != *name);
    let offered = interfaces
        .iter()
        .filter(|(tag, _)| root.child(tag).is_some());
    let offered = offered.flat_map(|(_, names)| names.split(' '));
    let shared = known.iter().copied().filter(is_shared);
    let mut names: Vec<String> = shared.chain(offered).map(String::from).collect();
    names.sort_unstable();
    Some(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counted in the headers of the standard: of 2.0 25 functions that both interfaces share, 9 of
    /// co-simulation, 10 of model exchange; of 3.0 58 that all share, 4 and 11.
    #[test]
    fn the_lists_are_complete() {
        let count = |version: &str, interfaces: &str| {
            let text = format!("<d>{interfaces}</d>");
            let document = uppsala::parse(&text).unwrap();
            required(Element::root(&document).unwrap(), version).map(|names| names.len())
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
