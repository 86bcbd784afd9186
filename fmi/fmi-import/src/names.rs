//! What the functions and statuses of FMI 2.0 are called in FMI 3.0.

use crate::standard::FMI3;

/// A text with the functions and statuses of FMI 2.0 in it called as FMI 3.0 calls them.
pub fn text_in_3(text: &str) -> String {
    let is_word = |c: char| c.is_ascii_alphanumeric();
    let mut told = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("fmi2") {
        let (before, from) = rest.split_at(start);
        let end = from.find(|c| !is_word(c)).unwrap_or(from.len());
        told += before;
        told += in_3(&from[..end]);
        rest = &from[end..];
    }
    told + rest
}

/// Functions and statuses that differ by more than the number in their names.
const OTHERS: [(&str, &str); 21] = [
    ("fmi2GetDerivatives", "fmi3GetContinuousStateDerivatives"),
    ("fmi2NewDiscreteStates", "fmi3UpdateDiscreteStates"),
    ("fmi2Instantiate", "fmi3InstantiateCoSimulation"),
    ("fmi2SetupExperiment", "fmi3EnterInitializationMode"),
    ("fmi2GetReal", "fmi3GetFloat64"),
    ("fmi2SetReal", "fmi3SetFloat64"),
    ("fmi2GetInteger", "fmi3GetInt64"),
    ("fmi2SetInteger", "fmi3SetInt64"),
    ("fmi2GetFMUstate", "fmi3GetFMUState"),
    ("fmi2SetFMUstate", "fmi3SetFMUState"),
    ("fmi2FreeFMUstate", "fmi3FreeFMUState"),
    ("fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize"),
    ("fmi2SerializeFMUstate", "fmi3SerializeFMUState"),
    ("fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState"),
    ("fmi2GetRealOutputDerivatives", "fmi3GetOutputDerivatives"),
    // No functions, so that they are not in the list of those.
    ("fmi2Status", "fmi3Status"),
    ("fmi2OK", "fmi3OK"),
    ("fmi2Warning", "fmi3Warning"),
    ("fmi2Discard", "fmi3Discard"),
    ("fmi2Error", "fmi3Error"),
    ("fmi2Fatal", "fmi3Fatal"),
];

/// What FMI 3.0 calls a function or status of FMI 2.0; the same where it has no such thing.
pub fn in_3(name: &str) -> &str {
    if let Some((_, three)) = OTHERS.iter().find(|(two, _)| *two == name) {
        return three;
    }
    let plain = name.strip_prefix("fmi2");
    let mut functions = FMI3.iter().map(|function| function.name);
    let function = functions.find(|three| plain.is_some() && three.strip_prefix("fmi3") == plain);
    function.unwrap_or(name)
}
