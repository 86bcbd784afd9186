//! A model description is read or refused; what it says of dependencies stays within its variables.
#![no_main]

use fmi_description::Description;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(description) = Description::read(bytes) {
        for output in 0..description.variables.len() {
            for initialization in [false, true] {
                for input in description.feedthrough(output, initialization) {
                    assert!(description.variables[input].is_input());
                }
            }
        }
    }
});
