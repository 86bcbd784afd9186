//! A system structure, or a parameter set, is read or refused. The parser's source is included, because `cosim` itself needs libclang.
#![no_main]

#[path = "../../crates/cosim/src"]
mod cosim {
    #[allow(dead_code)]
    pub mod ssd;
}

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(structure) = cosim::ssd::Structure::parse(text) {
        for connection in &structure.connections {
            assert!(structure.component(&connection.start.0).is_some(), "{connection}");
        }
    }
    if let Ok(set) = cosim::ssd::parse_set(text, "set.ssv") {
        assert!(set.iter().all(|parameter| parameter.origin.contains("set.ssv")));
    }
});
