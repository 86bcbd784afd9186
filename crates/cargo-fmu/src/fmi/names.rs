//! What the functions and statuses of FMI 2.0 are called in FMI 3.0.

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

/// What FMI 3.0 calls a function or status of FMI 2.0.
pub fn in_3(name: &str) -> &str {
    let names = [
        ("fmi2Instantiate", "fmi3InstantiateCoSimulation"),
        ("fmi2GetVersion", "fmi3GetVersion"),
        ("fmi2SetDebugLogging", "fmi3SetDebugLogging"),
        ("fmi2FreeInstance", "fmi3FreeInstance"),
        ("fmi2SetupExperiment", "fmi3EnterInitializationMode"),
        ("fmi2EnterInitializationMode", "fmi3EnterInitializationMode"),
        ("fmi2ExitInitializationMode", "fmi3ExitInitializationMode"),
        ("fmi2Terminate", "fmi3Terminate"),
        ("fmi2Reset", "fmi3Reset"),
        ("fmi2GetReal", "fmi3GetFloat64"),
        ("fmi2SetReal", "fmi3SetFloat64"),
        ("fmi2GetInteger", "fmi3GetInt64"),
        ("fmi2SetInteger", "fmi3SetInt64"),
        ("fmi2GetBoolean", "fmi3GetBoolean"),
        ("fmi2SetBoolean", "fmi3SetBoolean"),
        ("fmi2GetString", "fmi3GetString"),
        ("fmi2SetString", "fmi3SetString"),
        ("fmi2GetFMUstate", "fmi3GetFMUState"),
        ("fmi2SetFMUstate", "fmi3SetFMUState"),
        ("fmi2FreeFMUstate", "fmi3FreeFMUState"),
        ("fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize"),
        ("fmi2SerializeFMUstate", "fmi3SerializeFMUState"),
        ("fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState"),
        (
            "fmi2GetDirectionalDerivative",
            "fmi3GetDirectionalDerivative",
        ),
        ("fmi2GetRealOutputDerivatives", "fmi3GetOutputDerivatives"),
        ("fmi2DoStep", "fmi3DoStep"),
        ("fmi2Status", "fmi3Status"),
        ("fmi2OK", "fmi3OK"),
        ("fmi2Warning", "fmi3Warning"),
        ("fmi2Discard", "fmi3Discard"),
        ("fmi2Error", "fmi3Error"),
        ("fmi2Fatal", "fmi3Fatal"),
    ];
    let found = names.iter().find(|(two, _)| *two == name);
    found.map_or(name, |(_, three)| three)
}
