//! A model description is read or refused; what it says of dependencies stays within its variables.
#![no_main]

#[path = "../../crates/cosim/src"]
mod cosim {
    #[allow(dead_code)]
    pub mod description;
}

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(description) = cosim::description::Description::parse(text) {
        for output in 0..description.variables.len() {
            for initialization in [false, true] {
                for input in description.feedthrough(output, initialization) {
                    assert!(input < description.variables.len());
                }
            }
        }
    }
});
