//! A system structure, a parameter set, a mapping or a dictionary is read or refused with its
//! place.
#![no_main]

use libfuzzer_sys::fuzz_target;
use system_structure::{ParameterMapping, ParameterSet, SignalDictionary, SystemStructure};

fuzz_target!(|text: &str| {
    let errors = [
        SystemStructure::parse(text, "a.ssd").err(),
        ParameterSet::parse(text, "a.ssv").err(),
        ParameterMapping::parse(text, "a.ssm").err(),
        SignalDictionary::parse(text, "a.ssb").err(),
    ];
    let lines = 1 + text.matches('\n').count();
    for error in errors.into_iter().flatten() {
        assert!((1..=lines).contains(&error.line), "{error}");
    }
});
