//! A file whose elements are nested without end gets an error. Trees are read and dropped by
//! recursion, which would exhaust the stack otherwise.

use fmi_description::Description;
use system_structure::{ParameterMapping, ParameterSet, SignalDictionary, SystemStructure};

const LEVELS: usize = 200_000;

fn nested(root: &str, inner: &str) -> String {
    let (begin, end) = (format!("<{inner} name='s'>"), format!("</{inner}>"));
    let (begin, end) = (begin.repeat(LEVELS), end.repeat(LEVELS));
    format!("<{root} version='1.0' name='s'>{begin}{end}</{root}>")
}

#[test]
fn files_nested_too_deeply_are_refused() {
    let structure = nested("ssd:SystemStructureDescription", "ssd:System");
    let set = nested("ssv:ParameterSet", "ssv:Parameters");
    let mapping = nested("ssm:ParameterMapping", "ssm:MappingEntry");
    let dictionary = nested("ssb:SignalDictionary", "ssb:DictionaryEntry");
    let description = nested("fmiModelDescription", "ModelVariables");
    let errors = [
        SystemStructure::parse(&structure, "f")
            .map(drop)
            .map_err(|e| e.to_string()),
        ParameterSet::parse(&set, "f")
            .map(drop)
            .map_err(|e| e.to_string()),
        ParameterMapping::parse(&mapping, "f")
            .map(drop)
            .map_err(|e| e.to_string()),
        SignalDictionary::parse(&dictionary, "f")
            .map(drop)
            .map_err(|e| e.to_string()),
        Description::parse(&description)
            .map(drop)
            .map_err(|e| e.to_string()),
    ];
    for error in errors {
        let error = error.unwrap_err();
        let limit = "line 1: more than 256 elements are nested in each other";
        assert!(error.ends_with(limit), "{error}");
    }
}
