//! Training data in a CSV file: read or refused. The module is included: the rest of its crate has
//! nothing to do with it.
#![no_main]

#[path = "../../../studies/surrogate/src/measurement/data.rs"]
#[allow(dead_code)]
mod data;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(data) = data::parse_csv("fuzz.csv", text) {
        assert_eq!(data.inputs.len(), data.targets.len());
        assert!(data.inputs.iter().flatten().all(|x| x.is_finite()));
        assert!(data.targets.iter().flatten().all(|x| x.is_finite()));
    }
});
