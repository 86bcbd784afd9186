//! Translates names of functions and statuses of FMI 2.0 to FMI 3.0, for `functions`, and for
//! `fmu-check`, whose reports are written with those of FMI 2.0.

use crate::standard::FMI3;

/// A text in which all functions and statuses of FMI 2.0 have their names of FMI 3.0.
pub fn with_fmi3_names(text: &str) -> String {
    let is_word = |c: char| c.is_ascii_alphanumeric();
    let mut translated = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("fmi2") {
        let (before, from) = rest.split_at(start);
        let end = from.find(|c| !is_word(c)).unwrap_or(from.len());
        translated += before;
        translated += fmi3_name(&from[..end]);
        rest = &from[end..];
    }
    translated + rest
}

/// Functions whose names differ by more than the version and the case of letters.
const RENAMED: [(&str, &str); 9] = [
    ("fmi2GetDerivatives", "fmi3GetContinuousStateDerivatives"),
    ("fmi2NewDiscreteStates", "fmi3UpdateDiscreteStates"),
    ("fmi2Instantiate", "fmi3InstantiateCoSimulation"),
    ("fmi2SetupExperiment", "fmi3EnterInitializationMode"),
    ("fmi2GetReal", "fmi3GetFloat64"),
    ("fmi2SetReal", "fmi3SetFloat64"),
    ("fmi2GetInteger", "fmi3GetInt64"),
    ("fmi2SetInteger", "fmi3SetInt64"),
    ("fmi2GetRealOutputDerivatives", "fmi3GetOutputDerivatives"),
];

/// Names that are not those of functions.
const STATUSES: [&str; 6] = [
    "fmi3Status",
    "fmi3OK",
    "fmi3Warning",
    "fmi3Discard",
    "fmi3Error",
    "fmi3Fatal",
];

/// The name in FMI 3.0 of a function or status of FMI 2.0; unchanged if FMI 3.0 has no such thing.
pub(crate) fn fmi3_name(name: &str) -> &str {
    if let Some((_, renamed)) = RENAMED.iter().find(|(fmi2, _)| *fmi2 == name) {
        return renamed;
    }
    let Some(plain) = name.strip_prefix("fmi2") else {
        return name;
    };
    let mut names = FMI3.iter().map(|function| function.name).chain(STATUSES);
    let found = names.find(|fmi3| fmi3["fmi3".len()..].eq_ignore_ascii_case(plain));
    found.unwrap_or(name)
}
