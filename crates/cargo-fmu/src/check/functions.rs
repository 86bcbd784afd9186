//! The functions that a library must export, by version and interfaces.

use super::xml::Element;
use crate::fmi::Functions2;

/// Functions of FMI 2.0 for model exchange (section 3.2), with those that both interfaces share.
const MODEL_EXCHANGE_2: &str = "fmi2GetTypesPlatform fmi2GetVersion fmi2SetDebugLogging fmi2Instantiate fmi2FreeInstance \
    fmi2SetupExperiment fmi2EnterInitializationMode fmi2ExitInitializationMode fmi2Terminate fmi2Reset fmi2GetReal fmi2GetInteger \
    fmi2GetBoolean fmi2GetString fmi2SetReal fmi2SetInteger fmi2SetBoolean fmi2SetString fmi2GetFMUstate fmi2SetFMUstate \
    fmi2FreeFMUstate fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate fmi2GetDirectionalDerivative \
    fmi2EnterEventMode fmi2NewDiscreteStates fmi2EnterContinuousTimeMode fmi2CompletedIntegratorStep fmi2SetTime \
    fmi2SetContinuousStates fmi2GetDerivatives fmi2GetEventIndicators fmi2GetContinuousStates fmi2GetNominalsOfContinuousStates";

/// Functions of FMI 3.0 that all interfaces share (section 2.2), without `fmi3`, beside those that
/// get and set values.
const SHARED_3: &str = "GetVersion SetDebugLogging FreeInstance EnterInitializationMode ExitInitializationMode EnterEventMode \
    Terminate Reset GetNumberOfVariableDependencies GetVariableDependencies GetFMUState SetFMUState FreeFMUState SerializedFMUStateSize \
    SerializeFMUState DeserializeFMUState GetDirectionalDerivative GetAdjointDerivative EnterConfigurationMode ExitConfigurationMode \
    GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction SetIntervalDecimal SetIntervalFraction SetShiftDecimal \
    SetShiftFraction EvaluateDiscreteStates UpdateDiscreteStates";
const TYPES_3: &str =
    "Float32 Float64 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Boolean String Binary Clock";
const CO_SIMULATION_3: &str = "InstantiateCoSimulation EnterStepMode GetOutputDerivatives DoStep";
const MODEL_EXCHANGE_3: &str = "InstantiateModelExchange EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates \
    GetContinuousStateDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates GetNumberOfEventIndicators \
    GetNumberOfContinuousStates";
const SCHEDULED_3: &str = "InstantiateScheduledExecution ActivateModelPartition";

/// What an FMU with this model description must export; None for a version whose functions are not
/// known here.
pub fn required(root: Element, version: &str) -> Option<Vec<String>> {
    let offered = |tag: &str| root.child(tag).is_some();
    let mut names: Vec<String> = match version {
        "2.0" => {
            let co_simulation = offered("CoSimulation").then_some(Functions2::NAMES);
            let model_exchange = offered("ModelExchange").then_some(MODEL_EXCHANGE_2);
            let co_simulation = co_simulation.into_iter().flatten().copied();
            let model_exchange = model_exchange.into_iter().flat_map(str::split_whitespace);
            co_simulation
                .chain(model_exchange)
                .map(String::from)
                .collect()
        }
        version if version.starts_with("3.") => {
            let interfaces = [
                ("CoSimulation", CO_SIMULATION_3),
                ("ModelExchange", MODEL_EXCHANGE_3),
                ("ScheduledExecution", SCHEDULED_3),
            ];
            let own = interfaces.into_iter().filter(|(tag, _)| offered(tag));
            let own = own.flat_map(|(_, names)| names.split_whitespace());
            let plain = SHARED_3.split_whitespace().chain(own).map(String::from);
            let access = TYPES_3
                .split_whitespace()
                .flat_map(|t| [format!("Get{t}"), format!("Set{t}")]);
            plain
                .chain(access)
                .map(|name| format!("fmi3{name}"))
                .collect()
        }
        _ => return None,
    };
    names.sort_unstable();
    names.dedup();
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
